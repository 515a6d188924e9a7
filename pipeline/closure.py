"""What code a result depends on: modules by their imports, and a digest that comments leave alone.

No list names a file: the closure of a module is every module of ours that it imports, directly or
not, imports inside functions included and those for type checkers alone left out. What is imported
by name (a solver that a YAML names) has to be given as a root of its own.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Callable, Iterable
from functools import cache, cached_property, lru_cache
from importlib.util import find_spec
from pathlib import Path

import grimp

PACKAGES = ("pipeline", "baselines", "robots")
DATA_FILE = re.compile(r"[\w.-]+\.(?!py$)\w+")  # the name of a template, a style, a table
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


class SourceTree:
    """The modules of our packages, what each imports, and a digest of what each says.

    Args:
        read: Gives the bytes of a file; a test puts an edit in their place.
        packages: Top-level packages, each of which can be imported.
    """

    def __init__(
        self, read: Callable[[Path], bytes] = Path.read_bytes, packages: Iterable[str] = PACKAGES
    ) -> None:
        self._read = read
        self._packages = tuple(packages)
        self._digests: dict[str, str] = {}

    @cached_property
    def _graph(self) -> grimp.ImportGraph:
        first, *others = self._packages
        return grimp.build_graph(first, *others, exclude_type_checking_imports=True, cache_dir=None)

    def modules(self) -> frozenset[str]:
        """Return the names of all modules, packages included."""
        return frozenset(self._graph.modules)

    def path(self, module: str) -> Path:
        """Return the file of a module, for a package that of its ``__init__``."""
        top, *below = module.split(".")
        place = _folder(top).joinpath(*below)
        return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")

    def imports(self, module: str) -> set[str]:
        """Return what a module imports by itself, and the package whose ``__init__`` ran before."""
        found = set(self._graph.find_modules_directly_imported_by(module))
        package = module.rpartition(".")[0]
        return found | {package} if package else found

    def closure(self, *roots: str) -> frozenset[str]:
        """Return the modules that the roots may run, themselves included.

        Args:
            roots: Names of modules, such as ``pipeline.stages.train``.
        """
        found: set[str] = set()
        waiting = list(roots)
        while waiting:
            module = waiting.pop()
            if module not in found:
                found.add(module)
                waiting.extend(self.imports(module))
        return frozenset(found)

    def digests(self, *roots: str) -> dict[str, str]:
        """Return the digest of each module of a closure, by name in alphabetical order."""
        return {module: self._digest(module) for module in sorted(self.closure(*roots))}

    def digest(self, *roots: str) -> str:
        """Return 16 hexadecimal digits that change when code of the closure of the roots does."""
        text = "\n".join(f"{name} {value}" for name, value in self.digests(*roots).items())
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def _digest(self, module: str) -> str:
        if module not in self._digests:
            self._digests[module] = self._digest_of_file(self.path(module))
        return self._digests[module]

    def _digest_of_file(self, path: Path) -> str:
        """Digest of a module's code, and of the files beside it that it names (a template)."""
        if not path.exists():  # a folder of data without an __init__
            return ""
        digest, names = code_digest(self._read(path))
        beside = [path.parent / name for name in names]
        if not (files := [file for file in beside if file.is_file()]):
            return digest
        content = b"".join(file.name.encode() + self._read(file) for file in files)
        return hashlib.sha256(digest.encode() + content).hexdigest()[:16]


@cache
def source_tree() -> SourceTree:
    """Return the code that runs here, as it was when it was first needed."""
    return SourceTree()


def without_docstrings(tree: ast.Module) -> ast.Module:
    """Take the docstrings out of a syntax tree, which has no comments and no line breaks anyway."""
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return tree


@lru_cache(maxsize=1024)
def code_digest(source: bytes) -> tuple[str, tuple[str, ...]]:
    """Return the digest of a module's code and the text constants that may name a file beside it.

    Args:
        source: Of the module.
    """
    tree = without_docstrings(ast.parse(source))
    texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    names = sorted(text for text in texts if isinstance(text, str) and DATA_FILE.fullmatch(text))
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:16], tuple(names)


@cache
def _folder(package: str) -> Path:
    spec = find_spec(package)
    assert spec is not None and spec.submodule_search_locations
    return Path(spec.submodule_search_locations[0])
