"""Out to the machine: fitted maps in the forms that drives take, controllers and axes as code, the linear loop.

`to` makes what `cogging export` writes; `FORMS` lists what there is, and says how a form is added.
"""

from cogging.export.forms import FORMS, Exported, Form, Option, to

__all__ = ["FORMS", "Exported", "Form", "Option", "to"]
