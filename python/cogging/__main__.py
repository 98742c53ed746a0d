"""`python -m cogging`: the command."""

import sys

from cogging_command import main

if __name__ == "__main__":
    sys.exit(main())
