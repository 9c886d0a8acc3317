"""Runs the notebooks and keeps what they show, small: `python -m docs.make_notebooks [NAME ...]`.

Prints stay as text, pictures (PIL images, matplotlib figures, what has an HTML form) as small JPEG or HTML. No
kernel is needed: cells run one after the other in this process.
"""

import ast
import base64
import contextlib
import io
import json
import os
import re
import sys
import time
from pathlib import Path

import matplotlib as mpl

mpl.use("agg")
import matplotlib.pyplot as plt
from PIL import Image

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
WIDEST = 480
"""Pixels across, of a picture that is kept."""


def ran(source, names, path):
    """Run a cell; hand back its outputs as a notebook has them."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, str(path), "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), str(path), "eval"), names)
    outputs = []
    if printed.getvalue():
        outputs.append(
            {"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(True)}
        )
    outputs += [picture(figure_image(plt.figure(number))) for number in plt.get_fignums()]
    plt.close("all")
    if isinstance(value, Image.Image):
        outputs.append(picture(value))
    elif hasattr(value, "_repr_html_"):
        outputs.append(display({"text/html": [smaller(value._repr_html_())]}))
    elif value is not None and last is not None:
        outputs.append(display({"text/plain": repr(value).splitlines(True)}))
    return outputs


def smaller(page):
    """Keep the pictures within a page as small JPEG."""

    def jpeg(found):
        data = io.BytesIO()
        image = Image.open(io.BytesIO(base64.b64decode(found[1]))).convert("RGB")
        image.resize((image.width * 2 // 3, image.height * 2 // 3)).save(data, "JPEG", quality=70)
        return f"data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}"

    return re.sub(r"data:image/png;base64,([\w+/=]+)", jpeg, page)


def figure_image(figure):
    """Draw a figure."""
    data = io.BytesIO()
    figure.savefig(data, dpi=72)
    return Image.open(data)


def picture(image):
    """Keep an image small."""
    image = image.convert("RGB")
    if image.width > WIDEST:
        image = image.resize((WIDEST, round(image.height * WIDEST / image.width)), Image.Resampling.LANCZOS)
    data = io.BytesIO()
    image.save(data, "JPEG", quality=80, optimize=True)
    return display({"image/jpeg": base64.b64encode(data.getvalue()).decode()})


def display(data):
    """Wrap data as an output."""
    return {"output_type": "display_data", "metadata": {}, "data": data}


def main(names):
    """Run them all, or those of some names."""
    os.chdir(FOLDER)
    plt.show = lambda *a, **k: None
    for path in sorted(FOLDER.glob("*.ipynb")):
        if names and path.stem not in names:
            continue
        start, book, scope = (
            time.perf_counter(),
            json.loads(path.read_text("utf-8")),
            {"__name__": "__main__"},
        )
        for cell in book["cells"]:
            if cell["cell_type"] == "code":
                cell["outputs"] = ran("".join(cell["source"]), scope, path)
                cell["execution_count"] = None
        path.write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", "utf-8")
        print(f"{path.name}: {path.stat().st_size // 1024} KiB, {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
