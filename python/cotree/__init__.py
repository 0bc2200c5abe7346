"""Planar mechanisms: equations of motion in branch coordinates (McPhee 1998), simulation, sweeps, FMUs.

>>> import cotree
>>> model = cotree.loads('''
... name = "pendulum"
... gravity = [0.0, -9.81]
... [parameters]
... length = "1 m"
... [bodies.bob]
... mass = 1.0
... inertia = 0.0
... points = { top = [0.0, "length"] }
... [joints.hinge]
... type = "revolute"
... between = ["ground", "bob.top"]
... [initial]
... "bob.angle" = "10 deg"
... [outputs]
... variables = ["bob.angle"]
... [experiment]
... stop = "2 s"
... ''')
>>> results = model.simulate(set={"length": "500 mm"})
>>> results.units["bob.angle"]
'rad'

Numbers are in SI units, angles in radians; wherever a number is given, a text with a unit will do. Whatever is wrong with a scene is raised at once as
:class:`SceneError`; a motion that cannot be continued is a :class:`RunError`.
"""

from ._build import Builder
from ._commands import Assembly, Best, Profile, Report, dxf, png
from ._cotree import __version__
from ._faults import CotreeError, Fault, InternalError, Place, RunError, SceneError
from ._linkages import Linkages, inspect, load_linkage, synthesize
from ._given import RunOptions
from ._model import Model, Variable, from_dict, load, loads
from ._pieces import Stored
from ._results import Log, Logged, Results, ResultsList, Table
from ._run import Run
from ._show import Drawing
from ._studies import Equilibrium, Experiment, Fit, Fitted, Mode, Modes, Peak, Sensitivities, StateSpace

__all__ = [
    "Assembly",
    "Best",
    "Builder",
    "CotreeError",
    "Drawing",
    "Equilibrium",
    "Experiment",
    "Fault",
    "Fit",
    "Fitted",
    "InternalError",
    "Linkages",
    "Log",
    "Logged",
    "Mode",
    "Model",
    "Modes",
    "Peak",
    "Place",
    "Profile",
    "Report",
    "Results",
    "ResultsList",
    "Run",
    "RunError",
    "RunOptions",
    "SceneError",
    "Sensitivities",
    "StateSpace",
    "Stored",
    "Table",
    "Variable",
    "__version__",
    "dxf",
    "from_dict",
    "inspect",
    "load",
    "load_linkage",
    "loads",
    "png",
    "synthesize",
]
