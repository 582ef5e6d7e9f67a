#!/bin/sh
# compile_with_cache.sh SOURCE_TREE COMPILER ARGUMENTS...: compiles through ccache. Paths count relative to
# the source tree, so that a checkout elsewhere takes what this one has compiled; sloppiness is what
# ccache's manual asks for where headers are precompiled.
export CCACHE_BASEDIR="$1" CCACHE_NOHASHDIR=true CCACHE_SLOPPINESS=pch_defines,time_macros
shift
# A precompiled header that is there already would count as part of its own source.
previous=
for argument; do
  case "$previous $argument" in "-o "*.gch) rm -f "$argument" ;; esac
  previous=$argument
done
exec ccache "$@"
