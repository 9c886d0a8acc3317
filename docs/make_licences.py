"""Write `docs/licences.md`: everything that an installation runs on, with version and licence, from what is installed.

``python -m docs.make_licences``
"""

import importlib.metadata as metadata
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NAME = re.compile(r"[A-Za-z0-9._-]+")
BY_ITS_FILES = {"openexr": "BSD-3-Clause"}
"""Of those whose metadata names none."""

HEAD = """# Licences of what surftex runs on

Made by `python -m docs.make_licences` from the metadata of what is installed; surftex itself is MIT. The first table is what
`pip install surftex` brings, the others what each extra adds; tools of development are not listed. Wheels that carry
libraries of their own (imagecodecs, vtk, scipy, pillow) list the licences of these in their own files.
"""


def closure(names: list[str], known: frozenset[str] = frozenset()) -> dict[str, metadata.Distribution]:
    """Distributions by canonical name, with all that they need here."""
    found: dict[str, metadata.Distribution] = {}
    pending = [canonical(name) for name in names]
    while pending:
        name = pending.pop()
        if name in found or name in known:
            continue
        try:
            found[name] = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue  # needed on other systems only
        for need in found[name].requires or []:
            marker = need.partition(";")[2]
            if "extra" not in marker:
                pending.append(canonical(need))
    return dict(sorted(found.items()))


def canonical(requirement: str) -> str:
    match = NAME.match(requirement.strip())
    return re.sub(r"[-_.]+", "-", match.group() if match else requirement).lower()


def licence(distribution: metadata.Distribution) -> str:
    """By the expression, the classifiers, or the first line of the field, whichever is there."""
    about = distribution.metadata
    if about["License-Expression"]:
        return about["License-Expression"]
    named = [
        each.split(" :: ")[-1] for each in about.get_all("Classifier") or [] if each.startswith("License")
    ]
    first = (about["License"] or "").strip().splitlines()
    return ", ".join(named) or (
        first[0] if first and len(first[0]) < 60 else BY_ITS_FILES.get(canonical(about["Name"]), "?")
    )


def table(distributions: dict[str, metadata.Distribution]) -> str:
    rows = [f"| {name} | {each.version} | {licence(each)} |" for name, each in distributions.items()]
    return "\n".join(["| library | version | licence |", "| --- | --- | --- |", *rows]) + "\n"


def written() -> str:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    own = closure(project["dependencies"])
    text = f"{HEAD}\n{table(own)}"
    for extra, names in project["optional-dependencies"].items():
        if extra != "dev":
            text += f"\n## Extra `{extra}`\n\n{table(closure(names, frozenset(own)))}"
    return text


if __name__ == "__main__":
    (ROOT / "docs" / "licences.md").write_text(written(), "utf-8")
