#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests host_tests/figures: what it must find in pages and in the sources of tests."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))

from measure import marked, recorded  # noqa: E402  (the path comes first)

TESTS = """
TEST(Parser, IsBounded) {
  RecordProperty("promise", "R2");
}

TEST_P(ALongSuiteName,
       WithItsTestOnTheNextLine) {
  for (int i = 0; i < 3; ++i) {
    RecordProperty(
        "promise", "R4, R5");
  }
  // RecordProperty("promise", "R9") is only mentioned here
}

class Bench : public ::testing::Test {
 protected:
  void SetUp() override {
    RecordProperty("promise", "R6");
  }
  void fly(double seconds) {
    RecordProperty("promise", "R12");
  }
};

TEST_F(Bench, Flies) {
  fly(2.0);
}

TEST_F(Bench, Stands) {
}

void judge(const std::string& name) {
  std::replace_if(name.begin(), name.end(), [](char c) {
    return c == ' ';
  }, '_');
  ::testing::Test::RecordProperty("figure.ulp." + name, "0.5");
}

TYPED_TEST(Maths, IsExact) {
  judge("sin");
}
"""


class Recorded(unittest.TestCase):
    def test_finds_who_makes_each_call(self):
        calls = [(call.key, call.value, call.suite, call.test) for call in recorded.calls_of(TESTS)]
        self.assertEqual(calls, [("promise", "R2", "Parser", "IsBounded"),
                                 ("promise", "R4, R5", "ALongSuiteName", "WithItsTestOnTheNextLine"),
                                 ("promise", "R6", "Bench", "*"),
                                 ("promise", "R12", "Bench", "Flies"),
                                 ("figure.ulp.", "0.5", "Maths", "IsExact")])

    def test_refuses_a_call_that_no_test_makes(self):
        with self.assertRaises(ValueError):
            recorded.calls_of('void nobody_calls_this() {\n  RecordProperty("promise", "R1");\n}\n')


class Marked(unittest.TestCase):
    PAGE = "of <!-- figure: a.b -->2 079<!-- end --> and\n<!-- figure: table -->\n| 1 |\n<!-- end -->\n"

    def test_rewrites_what_was_measured_and_nothing_else(self):
        text, changes = marked.rewrite(self.PAGE, {"a.b": marked.Figure("2 100"), "other": marked.Figure("7")})
        self.assertEqual(text, self.PAGE.replace("2 079", "2 100"))
        self.assertEqual(changes, [("a.b", "2 079", "2 100")])

    def test_keeps_lines_apart_from_their_markers(self):
        text, _ = marked.rewrite(self.PAGE, {"table": marked.Figure("| 2 |\n| 3 |")})
        self.assertEqual(text, self.PAGE.replace("| 1 |", "| 2 |\n| 3 |"))

    def test_a_spread_hides_small_differences_only(self):
        self.assertEqual(marked.rewrite(self.PAGE, {"a.b": marked.Figure("2 081", 0.01)})[1], [])
        self.assertEqual(len(marked.rewrite(self.PAGE, {"a.b": marked.Figure("2 200", 0.01)})[1]), 1)
        self.assertEqual(len(marked.rewrite(self.PAGE, {"a.b": marked.Figure("2 079 B", 0.01)})[1]), 1)

    def test_the_same_measurement_changes_nothing(self):
        figures = {"a.b": marked.Figure("2 079"), "table": marked.Figure("| 1 |")}
        self.assertEqual(marked.rewrite(self.PAGE, figures), (self.PAGE, []))

    def test_refuses_markers_that_do_not_fit_together(self):
        for page in ("<!-- figure: a -->1", "1<!-- end -->", "<!-- figure: a -->1 <!-- figure: b -->2<!-- end -->"):
            with self.assertRaises(ValueError, msg=page):
                marked.names(page)


class Command(unittest.TestCase):
    """The command itself, on a scratch copy with one promise and one test."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        shutil.copytree(HERE / "measure", self.root / "host_tests" / "measure")
        shutil.copy(HERE / "figures", self.root / "host_tests" / "figures")
        (self.root / "host_tests" / "unit").mkdir()
        tests = TESTS.replace('"R4, R5"', '"R2"').replace("R6", "R2").replace("R12", "R2")
        (self.root / "host_tests" / "unit" / "a_test.cpp").write_text(tests)
        self.page = self.root / "firmware" / "safety" / "PROMISES.md"
        self.page.parent.mkdir(parents=True)
        self.page.write_text("### R2. Parser\n\n<!-- figure: promise.R2 -->\n<!-- end -->\n\n### R3. Other\n\n"
                             "<!-- figure: promise.R3 -->\n<!-- end -->\n")

    def tearDown(self):
        self.folder.cleanup()

    def figures(self, mode):
        return subprocess.run([sys.executable, self.root / "host_tests" / "figures", mode], capture_output=True, text=True,
                              check=False).returncode

    def test_finds_a_stale_page_mends_it_and_is_content(self):
        self.assertEqual(self.figures("--check"), 1)
        self.assertEqual(self.figures("--quick"), 0)
        self.assertIn("- unit: `ALongSuiteName.WithItsTestOnTheNextLine`, `Bench.*`, `Bench.Flies`, `Parser.IsBounded`\n", self.page.read_text())
        self.assertIn("**open**", self.page.read_text())
        self.assertEqual(self.figures("--check"), 0)

    def test_refuses_a_figure_that_nothing_measures_or_that_stands_twice(self):
        self.figures("--quick")
        page = self.root / "README.md"
        for text in ("<!-- figure: promise.R99 -->1<!-- end -->", "<!-- figure: nonsense -->1<!-- end -->",
                     "<!-- figure: promise.R3 -->**open**: no test names this promise yet.<!-- end -->"):
            page.write_text(text)
            self.assertEqual(self.figures("--check"), 2, text)

    def test_refuses_a_test_that_names_a_promise_which_is_not_stated(self):
        (self.root / "host_tests" / "unit" / "b_test.cpp").write_text(TESTS)
        self.assertEqual(self.figures("--check"), 2)

    def test_keeps_what_cannot_be_measured_here(self):
        page = self.root / "README.md"
        page.write_text("<!-- figure: cost.parts -->\nold\n<!-- end -->")
        self.figures("--quick")
        self.assertIn("old", page.read_text())


class FirstPage(unittest.TestCase):
    NAMES = ("Matrice 100", "A3, N3 and M600 up to firmware 3.2", "C++20", "Debian 12", "BSD-3-Clause")

    @classmethod
    def bare_numbers(cls, page):
        """-> numbers that no command writes: outside figures, code, links' targets, list marks and proper names"""
        text = marked.MARKED.sub("", page)
        text = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)|^\d+\. ", "", text, flags=re.DOTALL | re.MULTILINE)
        for name in cls.NAMES:
            text = text.replace(name, "")
        return re.findall(r"\S*\d\S*", text)

    def test_has_no_number_that_no_command_writes(self):
        self.assertEqual(self.bare_numbers((HERE.parent / "README.md").read_text()), [])

    def test_finds_a_planted_number(self):
        self.assertEqual(self.bare_numbers("1. `x 2` at <!-- figure: a -->3 m<!-- end --> and 4 m [a](b5)\n"), ["4"])


if __name__ == "__main__":
    unittest.main()
