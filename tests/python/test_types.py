import ast
import pathlib
import unittest

import prehend


# Attributes that __init__ gives.
kOfInstances = {"Stream": {"dropped"}, "Launch": {"registry"}}


class Types(unittest.TestCase):
    def test_say_what_is_there(self):
        interface = ast.parse(pathlib.Path(prehend.__file__).with_suffix(".pyi").read_text())
        named = {one.name: one for one in interface.body if isinstance(one, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(set(named), set(prehend.__all__))
        for name, node in named.items():
            if not isinstance(node, ast.ClassDef) or issubclass(getattr(prehend, name), Exception):
                continue
            told = {part.name if isinstance(part, ast.FunctionDef) else part.target.id
                    for part in node.body if isinstance(part, (ast.FunctionDef, ast.AnnAssign))}
            there = {part for part in vars(getattr(prehend, name)) if not part.startswith("_")}
            there |= kOfInstances.get(name, set())
            self.assertEqual({part for part in told if not part.startswith("_")}, there, name)

    def test_everything_explains_itself(self):
        for name in prehend.__all__:
            self.assertTrue(getattr(prehend, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()
