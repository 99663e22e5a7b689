"""The command line, as ``python -m fecontact``."""

import sys

from fecontact.app.cli import main

if __name__ == "__main__":
    sys.exit(main())
