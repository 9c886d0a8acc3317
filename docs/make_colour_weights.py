"""Makes ``surftex/optics/data/colour_weights.csv``: what light of each wavelength gives to linear sRGB under daylight.

``pip install colour-science==0.4.7`` and then ``python -m docs.make_colour_weights``; the package itself reads the
table and needs neither. Sources: CIE 1931 2 degree observer (CIE 15), CIE standard illuminant D65 (CIE 15), sRGB
primaries (IEC 61966-2-1). Each column is scaled to sum to 1, so that a perfect white is (1, 1, 1).
"""

from pathlib import Path

import colour
import numpy as np

TABLE = Path(__file__).resolve().parent.parent / "surftex" / "optics" / "data" / "colour_weights.csv"
HEADER = """# What the reflectance at each nanometre gives to linear sRGB in daylight; every column sums to 1.
# CIE 1931 2 degree observer and CIE standard illuminant D65 (CIE 15), sRGB primaries (IEC 61966-2-1).
# Made by docs/make_colour_weights.py with colour-science 0.4.7.
nm,red,green,blue
"""


def main():
    nm = np.arange(380, 781)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    daylight = colour.SDS_ILLUMINANTS["D65"]
    seen = np.array([observer[float(each)] for each in nm])
    light = np.interp(nm, daylight.wavelengths, daylight.values)
    weights = (seen * light[:, None]) @ np.asarray(colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB).T
    weights /= weights.sum(0)
    rows = "\n".join(f"{each},{r:.7f},{g:.7f},{b:.7f}" for each, (r, g, b) in zip(nm, weights, strict=True))
    TABLE.write_text(HEADER + rows + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
