"""python -m microfacet check KEY... --kept FOLDER --out FILE"""

import json
import sys
from pathlib import Path

from microfacet.statements.statement import equations

*keys, _, _, _, out = sys.argv[2:]
Path(out).write_text(json.dumps({key: equations[key].check() for key in keys}))
