"""Imported first by the process that helpers are forked from: no garbage is collected while it loads.

What libraries make when they are imported is kept, and to look through it again and again takes a sixth of the time.
Helpers collect garbage again (`pipeline.run.helpers`).
"""

import gc
import sys

__all__ = []

gc.disable()
# What cannot be loaded is told by the process that needs it.
sys.excepthook = lambda *_: None
