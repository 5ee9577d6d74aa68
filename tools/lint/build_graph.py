"""What BUILD files say: targets and their dependencies.

BUILD files of this project hold calls with literal arguments only, which is
what makes reading them without Bazel right; dependency_law_test compares the
result with what Bazel itself sees.
"""

import ast
import os

import tree

# Attributes whose labels a target depends on.
_DEPENDENCIES = ("deps", "srcs", "hdrs", "data", "implementation_deps",
                 "textual_hdrs")


class Target:
    """One target: its label, the labels that it names, whether for tests."""

    def __init__(self, label, kind, dependencies, testonly):
        self.label = label
        self.kind = kind
        self.dependencies = dependencies
        self.testonly = testonly

    @property
    def package(self):
        return self.label[2:].split(":")[0]


def _literal(node, where, constants):
    """Strings of a literal, list, select, constant or sum of these."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else []
    if isinstance(node, (ast.List, ast.Tuple)):
        return [item for part in node.elts
                for item in _literal(part, where, constants)]
    if isinstance(node, ast.BinOp):
        return (_literal(node.left, where, constants) +
                _literal(node.right, where, constants))
    if isinstance(node, ast.Name) and node.id in constants:
        return _literal(constants[node.id], where, constants)
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "glob":
        return []
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "select":
        return [item for part in node.args[0].values
                for item in _literal(part, where, constants)]
    raise ValueError(f"{where}:{node.lineno}: expected literal labels, found "
                     f"{ast.unparse(node)}")


def absolute(label, package):
    """A label with package and name spelled out."""
    if label.startswith("@"):
        return label if "//" in label else f"{label}//:{label[1:]}"
    if label.startswith("//"):
        path = label[2:]
        if ":" in path:
            return label
        return f"//{path}:{path.split('/')[-1]}"
    return f"//{package}:{label.lstrip(':')}"


def _target(call, package, where, testonly, constants):
    arguments = {keyword.arg: keyword.value for keyword in call.keywords}
    name = arguments.get("name")
    if not isinstance(name, ast.Constant):
        return None
    labels = []
    for attribute in _DEPENDENCIES:
        if attribute in arguments:
            labels += _literal(arguments[attribute], where, constants)
    own = arguments.get("testonly")
    if isinstance(own, ast.Constant):
        testonly = bool(own.value)
    kind = call.func.id
    dependencies = [absolute(label, package) for label in labels]
    if kind == "sinew_proto_library":
        dependencies.append("@system//:protobuf")
        if "grpc" in arguments and arguments["grpc"].value:
            dependencies.append("@system//:grpc")
    return Target(f"//{package}:{name.value}", kind, dependencies,
                  testonly or kind.endswith("_test"))


def targets(root):
    """All targets of the tree by label."""
    found = {}
    for path in tree.files(root):
        if os.path.basename(path) != "BUILD.bazel":
            continue
        package = os.path.dirname(path)
        testonly = False
        constants = {}
        for statement in ast.parse(tree.read(root, path), path).body:
            if isinstance(statement, ast.Assign):
                constants[statement.targets[0].id] = statement.value
                continue
            call = getattr(statement, "value", None)
            if not isinstance(call, ast.Call) or \
                    not isinstance(call.func, ast.Name):
                continue
            if call.func.id == "package":
                testonly = any(keyword.arg == "default_testonly" and
                               keyword.value.value
                               for keyword in call.keywords)
                continue
            if call.func.id in ("package_group", "config_setting", "alias"):
                continue
            target = _target(call, package, path, testonly, constants)
            if target is not None:
                found[target.label] = target
    return found
