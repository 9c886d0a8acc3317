"""Makes ``surftex/optics/data/skin_fits.csv`` and the presets of the six skin types; prints what the fits leave.

Run ``python -m docs.make_skin_types`` from the repository; a few seconds.
"""

from pathlib import Path

from surftex.materials.skin.model import Skin
from surftex.optics.appearance import lookup
from surftex.optics.colour import difference, lab, typology_angle
from surftex.optics.fitting import FREE, fit_reflectance
from surftex.optics.spectra import rgb_weights, table_rows

ROOT = Path(__file__).resolve().parent.parent / "surftex"
HEAD = f"""\
# Biology that fits the six mean spectra of skin_types.csv, by free paths of light over a base of albedo 0.5, at usual
# thicknesses; `rmse` in reflectance. A fit, not a measurement. Made by docs/make_skin_types.py.
class,{",".join(FREE)},rmse
"""
PRESET = """\
caption = "{Name} skin: fitted to the mean of {count} measured spectra, reflectance within {rmse:.4f} (rms)"
melanin = {melanin}
pheomelanin = {pheomelanin}
blood = {blood}
oxygenation = {oxygenation}
stratum_corneum = "0.01 mm"
epidermis = "0.1 mm"
# as much lighter and darker in patches as the usual, light skin; the same share of more melanin shows more
mottle = {mottle:.2f}
drift = {drift:.2f}
"""


def shown(biology: dict[str, float]) -> float:
    """How much darker 1.3 times the melanin looks, in L*."""
    colors = lookup({**biology, "melanin": [biology["melanin"], 1.3 * biology["melanin"]]}).base_color
    return float(lab(colors[0])[0] - lab(colors[1])[0])


def main() -> None:
    """Fit, print, write."""
    import numpy as np

    head, *rows = table_rows("skin_types.csv")
    nm, text = np.array(head[2:], np.float64), HEAD
    skin = Skin()
    usual = {each: getattr(skin, each) for each in FREE}
    for name, count, *values in rows:
        measured = np.array(values, np.float64)
        fit = fit_reflectance(nm, measured, base_albedo=0.5)
        short = {each: float(f"{fit.biology[each]:.4g}") for each in FREE}
        text += ",".join([name, *(f"{value:g}" for value in short.values()), f"{fit.rmse:.4f}"]) + "\n"
        seen = lookup(short).base_color[0] + 0.0415  # what the border, walked, reflects at 8 degrees
        color = measured @ rgb_weights(nm)
        print(
            f"{name:13} rmse {fit.rmse:.4f}  dE00 {difference(lab(color), lab(seen)):.2f}  "
            f"ITA {typology_angle(color):5.1f} against {typology_angle(seen):5.1f}  {short}"
        )
        even = min(1.0, shown(usual) / shown(short))
        preset = PRESET.format(
            Name=name.capitalize(), count=count, rmse=fit.rmse, mottle=even * skin.mottle, drift=even * skin.drift, **short
        )  # fmt: skip
        path = ROOT / "materials" / "presets" / "skin" / f"skin-{name.replace(' ', '-')}.toml"
        path.write_text(preset, "utf-8")
    (ROOT / "optics" / "data" / "skin_fits.csv").write_text(text, "utf-8")


if __name__ == "__main__":
    main()
