"""Which files of this checkout a Python source really needs: its import closure.

Snakemake sees declared inputs only, so every rule that runs a script declares what the script
imports, and what that imports in turn. `import microfacet as mf` alone costs nothing: the package
is lazy, so `mf.GGX` leads to the one module that its table of names (a dict literal in
`__init__.py`) gives for GGX. What a function of the library imports when it is called counts if
anything that is needed names that function. What cannot be followed (`f(mf)`, `getattr`, a module that imports by
computed names) counts as the whole package: too much is redone, never too little.

Packages are the library, and `report` beside it.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

PACKAGE = "microfacet"
PACKAGES = {PACKAGE: Path("lib"), "report": Path("lib"), "benchmarks": Path()}  # and the folder that each lies in
KEPT = Path("build/closures")
COMPUTED_IMPORTS = {"import_module", "__import__", "iter_modules", "walk_packages", "run_module"}


@cache
def module_file(name: str) -> Path | None:
    """The file of a module of the packages, or None where `name` is no module."""
    path = path_of(name)
    candidates = (path / "__init__.py", path.with_suffix(".py"))
    return next((c for c in candidates if c.is_file()), None)


def path_of(module: str) -> Path:
    parts = module.split(".")
    return PACKAGES.get(parts[0], Path("lib")).joinpath(*parts)


def is_ours(module: str) -> bool:
    return module.split(".")[0] in PACKAGES


def is_module(name: str) -> bool:
    return module_file(name) is not None or path_of(name).is_dir()


@cache
def parsed(source: str) -> ast.Module:
    return ast.parse(source)


def tree_of(file: Path) -> ast.Module:
    try:
        return parsed(file.read_text("utf-8"))
    except SyntaxError as error:
        error.filename = str(file)
        raise


@cache
def whole_package(package: str = PACKAGE) -> frozenset[Path]:
    return frozenset(path_of(package).rglob("*.py"))


@cache
def lazy_names(package: str) -> dict[str, str]:
    """The names a package's `__init__` promises, each with the module it lives in."""
    file = module_file(package)
    if file is None or file.name != "__init__.py":
        return {}
    names: dict[str, str] = {}
    for node in tree_of(file).body:
        value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        if isinstance(value, ast.Dict):
            names |= table_of(package, value)
    return names


def table_of(package: str, table: ast.Dict) -> dict[str, str]:
    """Name -> module out of `{"GGX": ".geometry.ggx"}` or `{"geometry.ggx": ("GGX", ...)}`."""
    try:
        literal = ast.literal_eval(table)
    except ValueError:
        return {}
    names: dict[str, str] = {}
    for key, value in literal.items():
        values = [value] if isinstance(value, str) else list(value)
        home = absolute(package, str(values[0])) if values else ""
        if module_file(home):
            names[key] = home
        elif module_file(absolute(package, key)):
            names |= dict.fromkeys(values, absolute(package, key))
    return names


def absolute(package: str, name: str) -> str:
    bare = name.lstrip(".")
    return bare if bare == package or bare.startswith(package + ".") else f"{package}.{bare}"


def needed(package: str, attributes: list[str]) -> set[str]:
    """The modules behind `package.a.b...`: follow submodules, then the table of lazy names."""
    if not attributes:
        return {"*"}
    first, *rest = attributes
    if home := lazy_names(package).get(first):
        return {f"{home}.{first}"} if is_module(f"{home}.{first}") else from_module(home, first)
    if is_module(f"{package}.{first}"):
        inner = f"{package}.{first}"
        if is_plain(inner):
            return from_module(inner, *rest[:1])
        return needed(inner, rest) if rest else {inner}
    return {package} if defines(package, first) else {"*"}


def from_module(module: str, name: str = "") -> set[str]:
    """A plain module, and the whole package if taking `name` from it imports by computed names."""
    return {module, "*"} if computes_imports(module, name) else {module}


@cache
def computes_imports(module: str, name: str) -> bool:
    """Follow the definitions inside the module from `name` (from all of it where there is none)."""
    used = uses(module)
    queue, visited = [name] if name else list(used), set[str]()
    while queue:
        one = queue.pop()
        if one in COMPUTED_IMPORTS:
            return True
        if one not in visited:
            visited.add(one)
            queue += used.get(one, set())
    return False


@cache
def uses(module: str) -> dict[str, set[str]]:
    """What each definition at the top of a module names."""
    file = module_file(module)
    body = tree_of(file).body if file is not None else []
    return {defined: names_in(node) for node in body for defined in defined_by(node)}


def names_in(node: ast.AST) -> set[str]:
    """Names that are used or imported."""
    kinds = {ast.Name: "id", ast.Attribute: "attr", ast.alias: "name"}
    return {getattr(inner, kinds[type(inner)]) for inner in ast.walk(node) if type(inner) in kinds}


def defined_by(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.Assign):
        return {t.id for t in node.targets if isinstance(t, ast.Name)}
    return {node.target.id} if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) else set()


def is_plain(name: str) -> bool:
    """A module that is one file, so that its attributes lead nowhere else."""
    file = module_file(name)
    return file is not None and file.name != "__init__.py"


@cache
def defines(module: str, name: str) -> bool:
    file = module_file(module)
    if file is None:
        return False
    body = tree_of(file).body
    return name.startswith("__") or any(name in defined_by(node) for node in body)


class Imports(ast.NodeVisitor):
    """Modules named by one source; `bound` are the local names that stand for a package."""

    def __init__(self, module: str = "", is_package: bool = False) -> None:
        self.parent = module if is_package else module.rpartition(".")[0]
        self.modules: set[str] = set()
        self.late: dict[str, set[str]] = {}
        self.bound: dict[str, str] = {}
        self.others: set[str] = set()
        self.inside = ""

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        outer, self.inside = self.inside, self.inside or node.name
        self.generic_visit(node)
        self.inside = outer

    visit_AsyncFunctionDef = visit_FunctionDef

    def bind(self, node: ast.Import) -> None:
        for alias in node.names:
            if is_ours(alias.name) and (not alias.asname or not is_plain(alias.name)):
                package = alias.name.split(".")[0]
                self.bound[alias.asname or package] = alias.name if alias.asname else package

    def name(self, modules: set[str]) -> None:
        """Modules named by an import: at once, or once the function around it is called."""
        if self.inside:
            self.late.setdefault(self.inside, set()).update(modules)
        else:
            self.modules |= modules

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            if not is_ours(alias.name):
                self.others.add(alias.name)
            elif alias.asname and is_plain(alias.name):
                self.name(from_module(alias.name))
            elif "." in alias.name and not alias.asname:
                self.name({alias.name})

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        base = self.base(node)
        if not is_ours(base):
            self.others.add(base)
        elif is_plain(base):
            for alias in node.names:
                self.name(from_module(base, "" if alias.name == "*" else alias.name))
        else:
            for alias in node.names:
                self.name(needed(base, [] if alias.name == "*" else [alias.name]))

    def base(self, node: ast.ImportFrom) -> str:
        if not node.level:
            return node.module or ""
        parts = self.parent.split(".")
        parts = parts[: len(parts) - node.level + 1]
        return ".".join([*parts, node.module] if node.module else parts)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        chain, inner = [node.attr], node.value
        while isinstance(inner, ast.Attribute):
            chain.append(inner.attr)
            inner = inner.value
        if isinstance(inner, ast.Name) and inner.id in self.bound:
            self.modules |= needed(self.bound[inner.id], chain[::-1])
        else:
            self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        if node.id in self.bound:
            self.modules.add("*")


def imports_of(tree: ast.Module, module: str = "", is_package: bool = False) -> Imports:
    imports = Imports(module, is_package)
    for node in ast.walk(tree):  # bindings first, wherever they stand
        if isinstance(node, ast.Import):
            imports.bind(node)
    imports.visit(tree)
    return imports


def imported_files(module: str) -> Iterator[Path]:
    """The file of a module and of every package it sits in (they run when it is imported).

    Without the package's own `__init__`: it only opens doors, and the doors are followed here, so
    a name added to its table changes nothing for modules that do not use it.
    """
    parts = module.split(".")
    for length in range(2, len(parts) + 1):
        file = module_file(".".join(parts[:length]))
        if file is not None:
            yield file


@cache
def module_imports(module: str) -> Imports:
    file = module_file(module)
    tree = tree_of(file) if file is not None else ast.Module(body=[], type_ignores=[])
    return imports_of(tree, module, file is not None and file.name == "__init__.py")


@cache
def module_names(module: str) -> frozenset[str]:
    """Every name that a module's code uses."""
    file = module_file(module)
    return frozenset(names_in(tree_of(file))) if file is not None else frozenset()


@cache
def of_source(source: str, folder: Path | None = None) -> frozenset[Path]:
    """Every file of the checkout that this source imports, directly or not.

    To read the whole library takes seconds, so answers are cached, by their dependencies.
    """
    beside = digest_of(folder.glob("*.py")) if folder else ""
    cache_file = KEPT / f"{digest(source, *(digest_of(whole_package(name)) for name in PACKAGES), beside)}.json"
    from microfacet.files import keep, recall

    known = recall(cache_file)
    if known is None:
        known = sorted(map(str, read_through(source, folder)))
        with suppress(OSError, ValueError):  # then it is read again
            keep(cache_file, known)
    return frozenset(map(Path, known))


@cache
def _text_of(path: Path) -> str:
    return path.read_text("utf-8")


def digest_of(files: Iterable[Path]) -> str:
    return digest(*(f"{path}\0{_text_of(path)}" for path in sorted(files)))


def digest(*parts: str) -> str:
    return hashlib.sha256("\0".join((*parts, sys.version, _text_of(Path(__file__)))).encode()).hexdigest()[:24]


def read_through(source: str, folder: Path | None) -> frozenset[Path]:
    tree = parsed(source)
    imports = imports_of(tree)
    files, modules, names = set(siblings(imports, folder)), set(imports.modules).union(*imports.late.values()), names_in(tree)
    for path in list(files):
        files |= of_source(path.read_text("utf-8"), folder)
        names |= names_in(tree_of(path))
    return frozenset(files | followed(modules, names))


def followed(modules: set[str], names: set[str]) -> set[Path]:
    """The files of modules and of what they import; `names` are those used so far, and grow with each module."""
    visited: set[str] = set()
    while rest := modules - visited - {"*"}:
        visited |= rest
        names = names.union(*map(module_names, rest))
        modules = modules.union(*(module_imports(module).modules for module in rest))
        for module in visited:
            late = module_imports(module).late
            modules |= set[str]().union(*(late[name] for name in late.keys() & names | {n for n in late if n.startswith("__")}))
    files = {file for module in visited for file in imported_files(module)}
    return files | whole_package() if "*" in modules else files


def siblings(imports: Imports, folder: Path | None) -> Iterator[Path]:
    """Helper modules that lie beside a script."""
    if folder is not None:
        for name in imports.others:
            path = folder / f"{name.split('.')[0]}.py"
            if path.is_file():
                yield path


def of_script(script: Path) -> list[str]:
    """The sorted import closure of a script, without the script itself."""
    files = of_source(script.read_text("utf-8"), script.parent)
    return sorted(str(path) for path in files if path != script)
