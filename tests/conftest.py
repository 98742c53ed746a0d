"""Set before numpy is imported: threads of the linear algebra that spin on two busy cores cost more than they bring."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
