"""The gallery of the site: what the examples in Python answer, with what they print and draw, and the notebook, executed.

    make_gallery.py ROOT OUT    ROOT: the source tree; OUT: a folder that it writes

PYTHONPATH has the package `prehend`.
"""

import ast
import os
import pathlib
import subprocess
import sys

QUIET = {"PYDEVD_DISABLE_FILE_VALIDATION": "1", "PYTHONDONTWRITEBYTECODE": "1"}


def main(root, out):
    examples = root / "examples" / "python"
    pictures = out / "pictures"
    environment = dict(os.environ, **QUIET)
    environment["PYTHONPATH"] = os.pathsep.join([str(examples), environment.get("PYTHONPATH", "")])
    subprocess.run([sys.executable, examples / "pictures.py", pictures], check=True, env=environment)
    subprocess.run([sys.executable, "-m", "nbconvert", "--execute", "--to", "markdown", "--log-level", "ERROR",
                    "--output-dir", out, examples / "from_cloud_to_grasp.ipynb"], check=True, env=environment,
                   stderr=subprocess.PIPE)
    pages = ["# Gallery", "",
             "What the scripts in `examples/python` answer, as this site was built. Each runs on your own clouds, meshes and "
             "recordings; `--picture FILE` draws what it prints. Step by step: "
             "[from a cloud to a grasp that holds](from_cloud_to_grasp.md), a notebook.", ""]
    for picture in sorted(pictures.glob("*.png")):
        words = ast.get_docstring(ast.parse((examples / f"{picture.stem}.py").read_text())).split("\n\n")
        pages += [f"## {words[0].strip()}", "", " ".join(words[2].split()), "",
                  f"![{words[0].strip()}](pictures/{picture.name})", "",
                  f"By `examples/python/{picture.stem}.py`:", "", "```text",
                  (pictures / f"{picture.stem}.txt").read_text().rstrip(), "```", ""]
    pages += ["```{toctree}", ":hidden:", "", "from_cloud_to_grasp", "```", ""]
    (out / "gallery.md").write_text("\n".join(pages))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
