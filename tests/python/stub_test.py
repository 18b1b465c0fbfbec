"""stub_test.py: __init__.pyi says what the compiled module has, name by name and argument by argument, and all of it has help().

Signatures of the module are those that pybind11 writes into its docs; types there are told by C++, and not compared.
"""
import ast
import pathlib
import re

import simuli


def arguments_of(function):
    """[(name, has a default)] of a function in the stub."""
    found = [(a.arg, False) for a in function.args.args]
    for i in range(len(function.args.defaults)):
        found[-1 - i] = (found[-1 - i][0], True)
    return found


def members_of(nodes):
    """name -> what it is in the stub: arguments, "property", or of a class its members."""
    out = {}
    for node in nodes:
        if isinstance(node, ast.ClassDef):
            out[node.name] = members_of(node.body)
        elif isinstance(node, ast.FunctionDef) and (node.name == "__init__" or not node.name.startswith("_")):
            kinds = [d.id for d in node.decorator_list]
            out[node.name] = "property" if "property" in kinds else arguments_of(node)
        elif isinstance(node, ast.AnnAssign):
            out[node.target.id] = "value"
    return out


def split(text):
    """At the commas that no bracket and no quotation holds."""
    parts, depth, quoted = [""], 0, False
    for c in text:
        quoted ^= c == "'"
        depth += 0 if quoted else (c in "([{") - (c in ")]}")
        if c == "," and depth == 0 and not quoted:
            parts.append("")
        else:
            parts[-1] += c
    return [part.strip() for part in parts if part.strip()]


def signature_of(function, name):
    """As arguments_of, of the compiled one; and what help() says beyond it."""
    first, _, said = function.__doc__.partition("\n")
    inside = re.fullmatch(re.escape(name) + r"\((.*)\) -> .+", first)
    assert inside, f"{name}: help begins with {first!r}"
    return [(part.split(":")[0].split("=")[0].strip(), " = " in part) for part in split(inside[1])], said.strip()


def compare(where, stub, members):
    names = {name for name in members if not name.startswith("_") or name in ("__init__", "__version__")}
    assert names == set(stub), f"{where}: the stub has {sorted(set(stub) - names)} too much, lacks {sorted(names - set(stub))}"
    for name, told in stub.items():
        is_, full = members[name], f"{where}.{name}"
        if isinstance(told, dict):
            made = getattr(vars(is_).get("__init__"), "__doc__", None) or ""
            own = {n: v for n, v in vars(is_).items() if n != "__init__" or made.startswith("__init__(self: ")}
            if issubclass(is_, Exception):
                own = {}
            compare(full, told, own)
            assert is_.__doc__ and is_.__module__ == "simuli", f"{full}: has no help, or is of {is_.__module__}"
        elif told == "property":
            assert isinstance(is_, property) and is_.__doc__, f"{full}: is no property, or has no help"
        elif told != "value":
            found, said = signature_of(getattr(is_, "__func__", is_), name)
            assert [(a, d) for a, d in found if a != "self"] == [(a, d) for a, d in told if a != "self"], (
                f"{full}: {found} in the module, {told} in the stub")
            assert said or name == "__init__", f"{full}: has no help"


package = pathlib.Path(simuli.__file__).parent
assert (package / "py.typed").exists()
stub = members_of(ast.parse((package / "__init__.pyi").read_text()).body)
public = {name: getattr(simuli, name) for name in [*simuli.__all__, "__version__"]}
compare("simuli", stub, public)
assert "Gaussians" in simuli.__doc__
print(len(stub), "names of the stub are those of the module")
