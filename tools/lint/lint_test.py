"""The checks find what they are for: each rule on a tree that breaks it."""

import os
import tempfile
import unittest

import build_graph
import dependency_law
import text_lint
import tree


def make_tree(files):
    """A tree of the given files, name -> text; returns its root."""
    root = tempfile.mkdtemp(dir=os.environ.get("TEST_TMPDIR"))
    for path, text in files.items():
        full = os.path.join(root, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "w", encoding="utf-8") as file:
            file.write(text)
    return root


def library(name, deps, rule="sinew_cc_library"):
    return f'{rule}(name = "{name}", deps = {list(deps)!r})\n'


def law_errors(packages):
    """Violations of a tree of packages, name -> BUILD file."""
    root = make_tree({f"{package}/BUILD.bazel": text
                      for package, text in packages.items()})
    return dependency_law.check(build_graph.targets(root))


class DependencyLaw(unittest.TestCase):

    def only_error(self, packages):
        errors = law_errors(packages)
        self.assertEqual(len(errors), 1, errors)
        return errors[0]

    def test_lets_layers_point_downwards(self):
        self.assertEqual([], law_errors({
            "common/files": library("files", ["@system//:absl"]),
            "sim/motion": library("motion", ["//common/files"]),
            "sim/world": library("world", ["//sim/motion", "@mujoco"]),
            "replay/client": library("client", ["//common/files"]),
            "actor": library("actor", ["//sim/world", "//replay/client"]),
            "learner": library("learner", ["//sim/motion",
                                           "@libtorch//:torch"]),
            "tools/sinew": library("sinew", ["//actor", "//learner"]),
        }))

    def test_refuses_layers_that_point_upwards(self):
        self.assertIn("sim/motion is not below common", self.only_error({
            "sim/motion": library("motion", []),
            "common": library("common", ["//sim/motion"]),
        }))

    def test_keeps_the_order_inside_sim(self):
        self.assertIn("sim/world is not below sim/import", self.only_error({
            "sim/world": library("world", []),
            "sim/import": library("import", ["//sim/world"]),
        }))

    def test_keeps_roles_apart(self):
        self.assertIn("learner is not below actor", self.only_error({
            "learner/ppo": library("ppo", []),
            "actor": library("actor", ["//learner/ppo"]),
        }))

    def test_lets_tests_of_a_role_use_the_fakes_of_another(self):
        packages = {
            "replay/testing": library("fake", []),
            "actor": library("t_test", ["//replay/testing:fake"],
                             rule="sinew_cc_test"),
        }
        self.assertEqual([], law_errors(packages))
        packages["actor"] = library("t", ["//replay/testing:fake"])
        self.assertIn("replay is not below actor", self.only_error(packages))

    def test_keeps_clients_apart(self):
        self.assertIn("a client may use proto and common", self.only_error({
            "replay/client": library("client", []),
            "learner/client": library("client", ["//replay/client"]),
        }))

    def test_keeps_clients_off_their_own_role(self):
        self.assertIn("a client may use proto and common", self.only_error({
            "replay": library("table", []),
            "replay/client": library("client", ["//replay:table"]),
        }))

    def test_keeps_learner_off_physics(self):
        self.assertIn("sim/motion alone", self.only_error({
            "sim/character": library("character", []),
            "learner": library("learner", ["//sim/character"]),
        }))

    def test_keeps_libtorch_in_learner(self):
        errors = law_errors({
            "actor": library("actor", ["@libtorch//:torch"]),
            "tools/sinew": library("sinew", ["@libtorch//:torch"]),
        })
        self.assertEqual(3, len(errors), errors)
        self.assertIn("//actor:actor reaches @libtorch", "".join(errors))

    def test_keeps_grpc_off_the_runtime_however_far(self):
        self.assertIn("the runtime runs without gRPC", self.only_error({
            "common/rpc": library("rpc", ["@system//:grpc"]),
            "common/blobs": library("blobs", ["//common/rpc"]),
            "deploy/runtime": library("runtime", ["//common/blobs"]),
        }))

    def test_counts_the_grpc_of_schemas(self):
        self.assertIn("the runtime runs without gRPC", self.only_error({
            "proto/sinew/v1":
                'sinew_proto_library(name = "x", srcs = ["x.proto"], '
                'grpc = True)\n',
            "deploy/runtime": library("runtime", ["//proto/sinew/v1:x"]),
        }))

    def test_keeps_mujoco_out_of_motion(self):
        self.assertIn("knows no MuJoCo", self.only_error({
            "sim/motion": library("motion", ["@mujoco"]),
        }))

    def test_reads_what_a_select_may_choose(self):
        self.assertIn("not below", self.only_error({
            "learner": library("learner", []),
            "common": 'sinew_cc_library(name = "c", deps = ["@system//:absl"]'
                      ' + select({"//x:y": ["//learner"]}))\n',
        }))

    def test_reads_named_lists(self):
        self.assertIn("not below", self.only_error({
            "learner": library("learner", []),
            "common": '_DEPS = ["//learner"]\n'
                      'sinew_cc_library(name = "c", deps = _DEPS + [])\n',
        }))

    def test_wants_a_layer_for_every_folder(self):
        self.assertIn("found a new one", self.only_error({
            "extras": library("extras", []),
        }))

    def test_notices_edges_that_no_build_file_spells_out(self):
        root = make_tree({
            "common/BUILD.bazel": library("a", [":b"]) + library("b", []) +
                                  library("c", []),
        })
        targets = build_graph.targets(root)

        self.assertEqual([], dependency_law.edges_unknown(
            targets, '  "//common:a" -> "//common:b"\n'))
        self.assertEqual(1, len(dependency_law.edges_unknown(
            targets, '  "//common:a" -> "//common:c"\n')))


class TextLint(unittest.TestCase):

    def errors(self, path, text):
        return list(text_lint.file_errors(make_tree({path: text}), path))

    def only_error(self, path, text):
        errors = self.errors(path, text)
        self.assertEqual(len(errors), 1, errors)
        return errors[0]

    def test_accepts_a_good_header(self):
        self.assertEqual([], self.errors(
            "common/a.h",
            "#ifndef SINEW_COMMON_A_H_\n#define SINEW_COMMON_A_H_\n"
            "// Use:\n//\n//   int x = F();\n//\n// TODO(ann): units.\n"
            "#endif  // SINEW_COMMON_A_H_\n"))

    def test_wants_guards_named_after_the_path(self):
        self.assertIn("SINEW_COMMON_A_H_", self.only_error(
            "common/a.h", "#ifndef A_H\n#define A_H\n#endif\n"))

    def test_counts_columns(self):
        self.assertIn("found 81", self.only_error(
            "a.cc", "// " + "word " * 15 + "end\n"))

    def test_wants_names_at_todos(self):
        self.assertIn("TODO(name)", self.only_error(
            "a.cc", "// TODO: later\n"))

    def test_finds_code_in_comments(self):
        for line in ("// x = F(y);", "  // Run(3);", "// if (x) {",
                     "// return x;", "// }"):
            self.assertIn("code in a comment",
                          self.only_error("a.cc", line + "\n"))

    def test_finds_tests_that_sleep(self):
        self.assertIn("sleeps", self.only_error(
            "a_test.cc", "  absl::SleepFor(absl::Seconds(1));\n"))

    def test_counts_lines(self):
        self.assertIn("found 401", self.only_error("a.cc", "int x;\n" * 401))

    def test_finds_blanks_and_tabs_and_missing_ends(self):
        self.assertIn("blanks", self.only_error("a.cc", "int x; \n"))
        self.assertIn("tab", self.only_error("a.cc", "\tint x;\n"))
        self.assertIn("newline", self.only_error("a.cc", "int x;"))

    def test_parses_scripts(self):
        self.assertIn("a.py:1", self.only_error("a.py", "def f(:\n"))
        self.assertIn("syntax error", self.only_error("a.sh", "if then\n"))

    def test_skips_what_is_built(self):
        root = make_tree({"bazel-out/a.cc": "", "runs/a.cc": "", "b/a.cc": ""})

        self.assertEqual(["b/a.cc"], tree.files(root))


if __name__ == "__main__":
    unittest.main()
