"""Export: maps for drives, controllers and axes as code, the linear loop.

`to` returns what `cogging export` writes; `FORMS` lists the forms.
"""

from cogging.export.forms import FORMS, Exported, Form, Option, to

__all__ = ["FORMS", "Exported", "Form", "Option", "to"]
