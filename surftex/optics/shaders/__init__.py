"""Render models to match skin to. A model is one file with a `Shader`; name it in `SHADERS`."""

from surftex.errors import InputError
from surftex.optics.shaders import ashikhmin_shirley, ggx_lambert, principled
from surftex.optics.shaders.shader import Geometry, Shader

SHADERS = {each.SHADER.name: each.SHADER for each in (ggx_lambert, principled, ashikhmin_shirley)}
"""Every model, by name."""

__all__ = ["SHADERS", "Geometry", "Shader", "shader_named"]


def shader_named(name: str) -> Shader:
    """Find a render model.

    Parameters
    ----------
    name : str
        Such as ``"principled"``.

    Returns
    -------
    shader : Shader
        From its file in this folder.

    Raises
    ------
    InputError
        Listing the known models.
    """
    if name not in SHADERS:
        raise InputError(f"there is no shader {name!r}; known are {', '.join(SHADERS)}")
    return SHADERS[name]
