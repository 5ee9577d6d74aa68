"""Counts the test cases of a Bazel run and says how it ended.

Usage: count_tests.py TESTLOGS BAZEL_STATUS

The last line printed is "N passed, N failed, N skipped". Exits with 0 only if
Bazel did and nothing failed.
"""

import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree


def current_targets():
    """Folders below testlogs that belong to targets of this tree: logs of
    targets that are gone stay behind and must not count."""
    query = subprocess.run(
        ["bazel", "query", "--noshow_progress", "tests(//...)"],
        check=True, capture_output=True, text=True)
    return [line[2:].replace(":", "/") for line in query.stdout.split()]


def count(xml_path):
    """(passed, failed, skipped) of one test.xml; GoogleTest's format or the
    one that Bazel writes for other tests."""
    cases = ElementTree.parse(xml_path).getroot().iter("testcase")
    passed = failed = skipped = 0
    for case in cases:
        if case.find("failure") is not None or case.find("error") is not None:
            failed += 1
        elif (case.find("skipped") is not None or
              case.get("result") == "skipped"):
            skipped += 1
        elif case.get("status") != "notrun":
            passed += 1
    return passed, failed, skipped


def main():
    logs, status = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    passed = failed = skipped = 0
    for target in current_targets():
        files = sorted((logs / target).glob("**/test.xml"))
        if not files:
            failed += 1
            print(f"no result: //{target} (not built, or timed out)")
        for xml_path in files:
            one = count(xml_path)
            passed, failed, skipped = (
                passed + one[0], failed + one[1], skipped + one[2])
    if status != 0 and failed == 0:
        failed = 1
        print(f"bazel ended with status {status}")
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 0 if failed == 0 and passed > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
