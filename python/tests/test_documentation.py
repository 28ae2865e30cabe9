"""What is said about every public name, and that it is true."""

import copy
import doctest
import importlib
import inspect
import pkgutil
import re

import nibabel
import numpy as np
import pytest

import rsph

from conftest import ROOT

MODULES = sorted(m.name for m in pkgutil.iter_modules(rsph.__path__) if m.name != "_rsph")
# Fields and shapes of arrays, units of numbers.
ARRAY = re.compile(r"Array|Vector|NDArray")
SHAPE = re.compile(r"shape|\([A-Z][^)]*, ?[^)]*\)|any shape|as `|as :", re.DOTALL)
UNIT = re.compile(
    r"\((m|s|kg|N|J|Pa|rad|Hz|1)[ ),/^*]|\bpixels?\b|\bindices\b|\b[Nn]umber\b|units|dimensionless"
    r"|\bas :meth:|\bStrain\b"
)


@pytest.mark.parametrize("name", MODULES)
def test_docstrings_run(name, monkeypatch):
    module = importlib.import_module(f"rsph.{name}")
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert doctest.testmod(module, optionflags=flags).failed == 0


def public():
    """Every public name: where it is, what it is, and what is said about it."""
    modules = [rsph, *(getattr(rsph, n) for n in rsph.__all__)]
    modules = [m for m in modules if inspect.ismodule(m)] + [rsph.errors, rsph.results]
    for module in {m.__name__: m for m in modules}.values():
        yield module.__name__, module, module.__doc__
        for name in module.__all__:
            item = getattr(module, name)
            if inspect.isfunction(item):
                yield f"{module.__name__}.{name}", item, item.__doc__
            if not inspect.isclass(item):
                continue
            yield f"{module.__name__}.{name}", item, item.__doc__
            for key, member in vars(item).items():
                if key.startswith("_"):
                    continue
                if isinstance(member, property):
                    yield f"{module.__name__}.{name}.{key}", member.fget, member.__doc__
                elif isinstance(member, classmethod | staticmethod):
                    yield f"{module.__name__}.{name}.{key}", member.__func__, member.__doc__
                elif inspect.isfunction(member):
                    yield f"{module.__name__}.{name}.{key}", member, member.__doc__


NAMES = {where: (item, said) for where, item, said in public()}


def test_there_is_something_to_look_at():
    assert len(NAMES) > 130


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_documented_with_shapes_and_units(name):
    item, said = NAMES[name]
    assert said, f"{name} has no docstring"
    assert len(said) > 10
    annotations = getattr(item, "__annotations__", {})
    if inspect.isclass(item):
        annotations = {
            **annotations,
            **{f"init {k}": v for k, v in getattr(item.__init__, "__annotations__", {}).items()},
        }
    arrays = [key for key, kind in annotations.items() if ARRAY.search(str(kind))]
    if not arrays:
        return
    # What stands at a field of a class counts as well.
    source = inspect.getsource(item) if inspect.isclass(item) else ""
    fields = "".join(re.findall('""".*?"""', source, re.DOTALL))
    assert SHAPE.search(said + fields), f"{name}: no shape for {arrays}"
    assert UNIT.search(said + fields), f"{name}: no unit for {arrays}"
    for key in arrays:
        plain = key.removeprefix("init ")
        if plain not in ("return", "self") and not key.startswith("_"):
            assert re.search(rf"\b{re.escape(plain)}\b", said + source), (
                f"{name}: nothing on {plain}"
            )


def blocks(path):
    """The Python of a page."""
    text = (ROOT / path).read_text()
    return [block.split("```")[0] for block in text.split("```python\n")[1:]]


def test_the_readme_and_the_guide_run(tmp_path, monkeypatch, capsys):
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    ball = np.linalg.norm(np.indices((30, 30, 30)) - 14.5, axis=0) < 11.0
    nibabel.save(nibabel.Nifti1Image(6 * ball.astype(np.int16), np.eye(4)), tmp_path / "s.nii.gz")
    (tmp_path / "s.nii.gz").rename(tmp_path / "segmentation.nii.gz")
    monkeypatch.chdir(tmp_path)
    # What the pages leave to the reader, and smaller bodies.
    names = {"np": np, "copy": copy, "rsph": rsph, "array": 6 * ball}
    names["stretch"] = np.linspace(1.0, 1.5, 20)
    names["stress"] = 1e3 * (names["stretch"] - names["stretch"] ** -2) * names["stretch"] ** 3
    names["affine_in_metres"] = np.diag([1e-3, 1e-3, 1e-3, 1.0])
    small = {"particles=1000": "particles=200", "particles=5000": "particles=200"}
    small |= {'"body.particles": 5000': '"body.particles": 200, "time.until": 0.2'}
    small |= {"until=1.0, every=0.1": "until=sim.time + 0.02, every=0.01"}
    (readme,) = blocks("README.md")
    guide = blocks("docs/guide/python.md")
    assert len(guide) == 4
    for block in [readme, *guide]:
        for large, little in small.items():
            block = block.replace(large, little)
        exec(block, names)
    assert names["run"].summary["status"] == "finished"
    assert names["liver"].volume == pytest.approx(1e-9 * ball.sum(), rel=0.01)
    assert names["other"].volume == pytest.approx(names["liver"].volume, rel=1e-6)
    assert len(capsys.readouterr().out.split()) == 4
