"""The dependency law of docs/architecture.md, checked on every target.

  layer 0   proto/, and lists in docs/ that tests read
  layer 1   common/
  layer 2   sim/motion < sim/character < sim/import < sim/world < sim/metrics
  layer 3   the clients: replay/client, learner/client, teacher/client,
            deploy/checkpoint/client
  layer 4   the roles: replay, actor, teacher, learner, deploy
  layer 5   tools, tests

A target may depend on lower layers and within its own folder. Beyond that:
  - tests of a role may use the testing/ folders of other roles, which ship
    their fakes there;
  - a client depends on layers 0 and 1 only, never on another client;
  - of sim, learner may use sim/motion alone;
  - tests and fakes of a role may use the fakes that another role ships in a
    folder named testing;
  - libtorch is named in learner/ alone, and nothing below layer 5 but learner/
    reaches it;
  - deploy/runtime reaches neither libtorch nor gRPC;
  - sim/motion, common and proto reach no MuJoCo;
  - OSMesa is named in tools/render alone.

Usage: dependency_law.py ROOT [GENQUERY_OUTPUT]. With the output of a genquery
of deps(...) as graph, also checks that Bazel sees no edge between targets of
ours that the BUILD files do not spell out.
"""

import re
import sys

import build_graph

_SIM_ORDER = ("sim/motion", "sim/character", "sim/import", "sim/world",
              "sim/metrics")
_CLIENTS = ("replay/client", "learner/client", "teacher/client",
            "deploy/checkpoint/client")
_ROLES = ("replay", "actor", "teacher", "learner", "deploy")
# Build rules, wheels and lint: no code of the product.
_RULES = ("tools/build", "tools/workspace", "tools/wrapper", "tools/lint")
_TORCH = "@libtorch//"
_MUJOCO = "@mujoco//"
_GRPC = "@system//:grpc"
_OSMESA = "@system//:osmesa"


def _below(package, folder):
    return package == folder or package.startswith(folder + "/")


def layer(package):
    """(layer, folder): what may depend on what is decided by these two.

    Raises ValueError for a folder that has no layer.
    """
    if package == "" or any(_below(package, rules) for rules in _RULES):
        return -1.0, ""
    for client in _CLIENTS:
        if _below(package, client):
            return 3.0, client
    for index, folder in enumerate(_SIM_ORDER):
        if _below(package, folder):
            return 2 + index / 10, folder
    top = package.split("/")[0]
    for value, folders in ((0.0, ("proto", "docs")), (1.0, ("common",)),
                           (4.0, _ROLES), (5.0, ("tools", "tests"))):
        if top in folders:
            return value, top
    raise ValueError(f"//{package}: expected one of the folders of "
                     "tools/lint/dependency_law.py, found a new one")


def edge_error(target, dependency):
    """Why the target may not name a target of ours; "" if it may."""
    own_layer, own_folder = layer(target.package)
    package = dependency[2:].split(":")[0]
    its_layer, its_folder = layer(package)
    if own_layer < 0 or its_layer < 0 or own_folder == its_folder:
        return ""
    if own_layer == 5 and its_layer == 5:
        return "" if own_folder == "tests" else "tools may not use tests"
    if own_layer == its_layer == 4 and target.testonly and \
            package.split("/")[-1] == "testing":
        return ""
    if own_layer == 3 and its_layer >= 2:
        return "a client may use proto and common alone"
    if own_folder == "learner" and 2 <= its_layer < 3 and \
            its_folder != "sim/motion":
        return "of sim, learner may use sim/motion alone"
    if target.testonly and its_layer == own_layer == 4 and \
            package.endswith("/testing"):
        return ""
    if its_layer >= own_layer:
        return f"{its_folder} is not below {own_folder}"
    return ""


def _naming_error(target, dependency):
    """Why the target may not name a library of others; "" if it may."""
    folder = layer(target.package)[1]
    if dependency.startswith(_TORCH) and folder != "learner":
        return "libtorch is for learner/ alone"
    if dependency == _OSMESA and not _below(target.package, "tools/render"):
        return "OSMesa is for tools/render alone"
    return ""


def _reach(targets):
    """Label -> every label that it reaches, itself included."""
    reached = {}

    def visit(label):
        if label in reached:
            return reached[label]
        reached[label] = found = {label}
        if label in targets:
            for dependency in targets[label].dependencies:
                found |= visit(dependency)
        return found

    for label in targets:
        visit(label)
    return reached


def _reach_errors(target, reached):
    value, folder = layer(target.package)
    errors = []

    def forbid(prefix, why):
        for label in sorted(reached):
            if label.startswith(prefix):
                errors.append(f"{target.label} reaches {label}: {why}")
                return

    if 0 <= value < 5 and folder != "learner":
        forbid(_TORCH, "below tools, only learner/ reaches libtorch")
    if _below(target.package, "deploy/runtime") and not target.testonly:
        forbid(_TORCH, "the runtime runs without libtorch")
        forbid(_GRPC, "the runtime runs without gRPC")
    if folder in ("proto", "common", "sim/motion") or value == 3.0:
        forbid(_MUJOCO, f"{folder} knows no MuJoCo")
    return errors


def check(targets):
    """All violations, one sentence each."""
    errors = []
    reached = _reach(targets)
    for label, target in sorted(targets.items()):
        try:
            layer(target.package)
        except ValueError as error:
            errors.append(str(error))
            continue
        for dependency in target.dependencies:
            if dependency.startswith("//"):
                if dependency in targets and \
                        "." not in dependency.split(":")[1]:
                    why = edge_error(target, dependency)
                else:
                    why = ""
            else:
                why = _naming_error(target, dependency)
            if why:
                errors.append(f"{label} names {dependency}: {why}")
        errors += _reach_errors(target, reached[label])
    return errors


def edges_unknown(targets, graph):
    """Edges of a genquery's graph between our targets that we do not know.

    Those to build rules are the macros' own (precompiled headers).
    """
    reached = _reach(targets)
    errors = []
    for source, sink in re.findall(r'^\s*"([^"]+)" -> "([^"]+)"', graph,
                                   re.MULTILINE):
        if source in targets and sink in targets and \
                sink not in reached[source] and \
                layer(targets[sink].package)[0] >= 0:
            errors.append(f"Bazel sees {source} -> {sink}, "
                          "which no BUILD file spells out")
    return errors


def main(arguments):
    targets = build_graph.targets(arguments[0])
    errors = check(targets)
    if len(targets) < 100:
        errors.append(f"expected hundreds of targets, found {len(targets)}")
    if len(arguments) > 1:
        with open(arguments[1], encoding="utf-8") as file:
            graph = file.read()
        if '" -> "' not in graph:
            errors.append(f"{arguments[1]}: expected edges, found none")
        errors += edges_unknown(targets, graph)
    for error in errors:
        print(error, file=sys.stderr)
    print(f"{len(targets)} targets, {len(errors)} violations")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
