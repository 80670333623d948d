# The names of the package with their types, as in PUBLIC of __init__.py, which loads each when it is first asked for.

from microfacet.brdf.base import BRDF as BRDF
from microfacet.brdf.compensation import Compensated as Compensated
from microfacet.brdf.diffuse import Diffuse as Diffuse
from microfacet.brdf.microfacet import Microfacet as Microfacet
from microfacet.brdf.random_walk import RandomWalk as RandomWalk
from microfacet.directions import half_vector as half_vector
from microfacet.directions import reflect as reflect
from microfacet.directions import spherical as spherical
from microfacet.enough.choice import choose as choose
from microfacet.frame import Frame as Frame
from microfacet.geometry.beckmann import Beckmann as Beckmann
from microfacet.geometry.blinn_phong import BlinnPhong as BlinnPhong
from microfacet.geometry.blinn_phong import NormalizedBlinnPhong as NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX as GGX
from microfacet.geometry.roughness import alpha_from_roughness as alpha_from_roughness
from microfacet.geometry.roughness import stretched_alpha as stretched_alpha
from microfacet.geometry.slopes import Distribution as Distribution
from microfacet.geometry.ward import Ward as Ward
from microfacet.material.fresnel import Conductor as Conductor
from microfacet.material.fresnel import Dielectric as Dielectric
from microfacet.material.fresnel import F82Tint as F82Tint
from microfacet.material.fresnel import Fresnel as Fresnel
from microfacet.material.fresnel import Schlick as Schlick
from microfacet.statements.statement import equations as equations
from microfacet.validation.adaptive import seen_area as seen_area
from microfacet.validation.equations import validate as validate
from microfacet.visibility.masking import Masking as Masking
from microfacet.visibility.smith import Smith as Smith
from microfacet.visibility.unphysical import Implicit as Implicit
from microfacet.visibility.unphysical import Kelemen as Kelemen
from microfacet.visibility.unphysical import SchlickSmith as SchlickSmith
from microfacet.visibility.v_cavity import VCavity as VCavity

__version__: str
