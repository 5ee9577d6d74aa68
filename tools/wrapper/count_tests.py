"""Counts the test cases of a Bazel run and says how it ended.

Usage: count_tests.py EVENTS BAZEL_STATUS

EVENTS is what `bazel test --build_event_json_file` wrote: it names the logs of
this run, cached ones too, where the folder of logs also has those of targets
and runs that are gone. The last line printed is "N passed, N failed, N
skipped". Exits with 0 only if Bazel did and nothing failed.
"""

import json
import pathlib
import subprocess
import sys
import urllib.parse
import xml.etree.ElementTree as ElementTree


def current_targets():
    """Labels of the tests of this tree."""
    query = subprocess.run(
        ["bazel", "query", "--noshow_progress", "tests(//...)"],
        check=True, capture_output=True, text=True)
    return query.stdout.split()


def logs_of_run(events):
    """Paths of test.xml by label; of a shard or run that was tried again, the
    last one."""
    latest = {}
    for line in events.read_text().splitlines():
        event = json.loads(line)
        ran = event.get("id", {}).get("testResult")
        if ran is None:
            continue
        for output in event["testResult"].get("testActionOutput", []):
            if output["name"] == "test.xml":
                key = (ran["label"], ran.get("run"), ran.get("shard"))
                uri = urllib.parse.urlparse(output["uri"])
                latest[key] = pathlib.Path(urllib.parse.unquote(uri.path))
    logs = {}
    for key, path in sorted(latest.items(), key=str):
        logs.setdefault(key[0], []).append(path)
    return logs


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
    events, status = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    logs = logs_of_run(events)
    passed = failed = skipped = 0
    for target in current_targets():
        files = [path for path in logs.get(target, []) if path.exists()]
        if not files:
            failed += 1
            print(f"no result: {target} (not built, or timed out)")
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
