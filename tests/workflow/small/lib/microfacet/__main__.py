"""python -m microfacet check KEY --out FILE"""

import json
import sys
from pathlib import Path

from microfacet.statement import equations

_, key, _, out = sys.argv[1:]
Path(out).write_text(json.dumps(equations[key].check()))
