"""Recipe to maps, and the report of it.

The room shares its name with the function `surftex.bake`, so it can be called as well.
"""

import sys
from types import ModuleType
from typing import Any


class _Room(ModuleType):
    """Importing any module of the room puts the room where `surftex.bake`, the function, is looked up."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from surftex.bake.bake import bake

        return bake(*arguments, **options)


sys.modules[__name__].__class__ = _Room
