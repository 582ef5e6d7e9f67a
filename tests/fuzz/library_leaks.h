#pragma once

/// Leaks of libraries' own, of some hundreds of bytes for a file that they refuse, are none of what
/// is looked for here: Assimp's where it throws within a reader, Coin's of prototypes (VRML 2).
/// LeakSanitizer, where it is there, asks for this.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libassimp.so\nleak:libCoin.so\n";
}
