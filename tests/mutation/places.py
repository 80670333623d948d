"""Places in Python files where one small mistake can be made, and the text with that mistake in it.

A number (one more or one less, doubled or halved), True and False, a comparison (its opposite, or with its bound), an
operator of arithmetic, a sign, `and` and `or`, a condition, a statement or a named argument left out, a value returned.
Docstrings, types, strings, slides that are cited, what is said when something is refused, and assertions are no places. Nor are
the arguments, written as a list of tuples, at which a statement is enclosed: it holds at any.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

EDGE = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">"}
OPPOSITE = {
    ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==",
    ast.In: "not in", ast.NotIn: "in", ast.Is: "is not", ast.IsNot: "is",
}  # fmt: skip
ARITHMETIC = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*"),
    ast.FloorDiv: ("//", "*"), ast.Mod: ("%", "*"), ast.BitAnd: ("&", "|"), ast.BitOr: ("|", "&"), ast.MatMult: ("@", "*"),
}  # fmt: skip
ASSERTED = {"strict", "check", "positive", "real", "nonnegative", "integer", "dtype"}
SAID = {"digits", "slides"}  # how many are kept, and what is cited
WORDS = {"print", "warn", "debug", "info", "set_title", "set_xlabel", "set_ylabel"}  # calls that only say something


@dataclass(frozen=True)
class Place:
    """A stretch of a file's text, what may stand there instead, and the function around it ("" for the module)."""

    file: str
    line: int
    start: int
    stop: int
    others: tuple[str, ...]
    rule: str
    function: str

    def mutant(self, text: str, random: Random) -> str:
        data = text.encode()
        return (data[: self.start] + random.choice(self.others).encode() + data[self.stop :]).decode()


def of_file(root: Path, file: str) -> list[Place]:
    """All places of one file, each once, in the order of the text."""
    text = (root / file).read_text("utf-8")
    finder = _Finder(file, text)
    finder.visit(ast.parse(text))
    return sorted(finder.found, key=lambda place: (place.start, place.stop, place.rule))


class _Finder(ast.NodeVisitor):
    def __init__(self, file: str, text: str) -> None:
        self.file, self.data = file, text.encode()
        self.found: list[Place] = []
        self.functions: list[str] = []
        self.enclosed = False
        self.lines = [0]
        for line in self.data.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))

    def span(self, node: ast.AST) -> tuple[int, int]:
        start = self.lines[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        return start, self.lines[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def put(self, rule: str, node: ast.AST, start: int, stop: int, *others: str) -> None:
        line = self.data.count(b"\n", 0, start) + 1
        self.found.append(Place(self.file, line, start, stop, others, rule, ".".join(self.functions)))

    def replace(self, rule: str, node: ast.AST, *others: str) -> None:
        self.put(rule, node, *self.span(node), *others)

    def between(self, rule: str, before: ast.AST, after: ast.AST, old: str, *others: str) -> None:
        """Replace the operator that stands between two parts."""
        low, high = self.span(before)[1], self.span(after)[0]
        at = self.data.find(old.encode(), low, high)
        if at >= 0:
            self.put(rule, before, at, at + len(old.encode()), *others)

    def text(self, node: ast.AST) -> str:
        start, stop = self.span(node)
        return self.data[start:stop].decode()

    # --- what holds no places ------------------------------------------------------------------------------------

    def visit_Raise(self, node: ast.Raise) -> None: ...

    def visit_Assert(self, node: ast.Assert) -> None: ...

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None: ...

    def visit_arg(self, node: ast.arg) -> None: ...

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        """dict[str, int] is a type."""
        if isinstance(node.value, ast.Name) and node.value.id in ("dict", "list", "tuple", "set", "Callable"):
            return
        self.generic_visit(node)

    # --- what does -----------------------------------------------------------------------------------------------

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.functions.append(node.name)
        self.returns = ast.unparse(node.returns) if node.returns else ""
        for part in (*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None), *node.body):
            self.visit(part)
        self.functions.pop()

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.functions.append(node.name)
        for part in node.body:
            self.visit(part)
        self.functions.pop()

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" not in ast.unparse(node.test) and "__main__" not in ast.unparse(node.test):
            self.condition(node.test)
            self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        self.condition(node.test)
        self.generic_visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self.condition(node.test)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self.condition(test)
        self.generic_visit(node)

    def condition(self, test: ast.expr) -> None:
        """A comparison, a constant, `not` and `and` have places of their own."""
        if not isinstance(test, ast.Compare | ast.Constant | ast.BoolOp | ast.UnaryOp):
            self.replace("a condition turned round", test, f"(not ({self.text(test)}))")

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if isinstance(value, bool):
            self.replace("True and False", node, str(not value))
        elif isinstance(value, int):
            self.replace("a number", node, str(value + 1), f"({value - 1})")
        elif isinstance(value, float):
            self.replace("a number", node, *((repr(value * 2), repr(value / 2)) if value else ("1.0",)))

    def visit_Compare(self, node: ast.Compare) -> None:
        sides = [node.left, *node.comparators]
        for k, operator in enumerate(node.ops):
            written = _written(operator)
            self.between("a comparison turned round", sides[k], sides[k + 1], written, OPPOSITE[type(operator)])
            if type(operator) in EDGE and any(_whole(side) for side in (sides[k], sides[k + 1])):
                self.between("a bound", sides[k], sides[k + 1], written, EDGE[type(operator)])
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if type(node.op) in ARITHMETIC and not any(_said(side) for side in (node.left, node.right)):
            old, new = ARITHMETIC[type(node.op)]
            self.between("an operator", node.left, node.right, old, new)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub | ast.Not | ast.Invert):
            self.replace("a sign", node, f"({self.text(node.operand)})")
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for before, after in zip(node.values, node.values[1:], strict=False):
            self.between("and and or", before, after, old, new)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        self.visit(node.func)
        for argument in () if getattr(node.func, "attr", "") == "reshape" else node.args:  # any number below 0 is "the rest"
            self.visit(argument)
        for keyword in node.keywords:
            if keyword.arg not in ASSERTED | SAID:
                self.left_out(node, keyword)
                self.enclosed = keyword.arg == "enclosed"
                self.visit(keyword.value)
                self.enclosed = False

    def visit_List(self, node: ast.List) -> None:
        """Arguments at which a statement is enclosed, or a list like any other."""
        if not (self.enclosed and all(isinstance(each, ast.Tuple) for each in node.elts)):
            self.generic_visit(node)

    def left_out(self, call: ast.Call, keyword: ast.keyword) -> None:
        """A named argument, unless it is a text or the call has no other arguments."""
        if keyword.arg is None or _said(keyword.value) or len(call.args) == 0:
            return
        start, stop = self.span(keyword)
        while self.data[stop : stop + 1] in (b" ", b"\n"):
            stop += 1
        self.put("an argument left out", keyword, start, stop + (self.data[stop : stop + 1] == b","), "")

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return
        called = node.value.func if isinstance(node.value, ast.Call) else node.value
        name = getattr(called, "attr", getattr(called, "id", ""))
        if name in WORDS:
            return
        if isinstance(node.value, ast.Call):
            self.replace("a statement left out", node, "pass")
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self.replace("a statement left out", node, "pass")
        if type(node.op) in ARITHMETIC:
            old, new = ARITHMETIC[type(node.op)]
            self.between("an operator", node.target, node.value, f"{old}=", f"{new}=")
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        if all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
            self.replace("a statement left out", node, "pass")
        self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is None:
            return
        if self.returns == "bool":
            self.replace("a value returned", node.value, f"(not ({self.text(node.value)}))")
        elif self.returns == "float":
            self.replace("a value returned", node.value, f"(-({self.text(node.value)}))")
        self.generic_visit(node)

    def visit_Break(self, node: ast.Break) -> None:
        self.replace("a jump", node, "continue")

    def visit_Continue(self, node: ast.Continue) -> None:
        self.replace("a jump", node, "break")


def _written(operator: ast.cmpop) -> str:
    return next(text for kind, text in _COMPARISONS if isinstance(operator, kind))


_COMPARISONS = [
    (ast.LtE, "<="), (ast.GtE, ">="), (ast.Lt, "<"), (ast.Gt, ">"), (ast.Eq, "=="), (ast.NotEq, "!="),
    (ast.NotIn, "not in"), (ast.In, "in"), (ast.IsNot, "is not"), (ast.Is, "is"),
]  # fmt: skip


def _whole(side: ast.expr) -> bool:
    """Where a bound itself can be met: a whole number or a length. Rounded numbers meet a bound by chance, or never."""
    if isinstance(side, ast.Call) and isinstance(side.func, ast.Name):
        return side.func.id == "len"
    return isinstance(side, ast.Constant) and (isinstance(side.value, int) or side.value == 0)


def _said(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def files(root: Path) -> list[str]:
    """The library, the scripts that compute figures' data, and what builds the report."""
    found = [*root.glob("lib/**/*.py"), *root.glob("figures/**/*_data.py"), *root.glob("workflow/*.py")]
    return sorted(str(path.relative_to(root)) for path in found)


def all_places(root: Path, among: list[str]) -> Iterator[Place]:
    for file in among:
        yield from of_file(root, file)
