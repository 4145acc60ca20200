# Run at each build: writes OUTPUT with the commit of SOURCE_DIR if git has one, otherwise the
# commit in commit.txt, which `git archive` and packaging/build write.
#   cmake -DSOURCE_DIR=… -DOUTPUT=… -P BissCommit.cmake
execute_process(COMMAND git -C "${SOURCE_DIR}" describe --always --dirty --abbrev=40 --match=-
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
                RESULT_VARIABLE failed)
# A source folder inside another repository does not have its commit.
execute_process(COMMAND git -C "${SOURCE_DIR}" rev-parse --show-prefix
                OUTPUT_VARIABLE prefix OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(failed OR prefix)
  file(STRINGS "${SOURCE_DIR}/cmake/commit.txt" commit REGEX "^[0-9a-f]+(-dirty)?$")
endif()
set(text "#include \"verbs/common/program.hpp\"

namespace biss::verbs {
const char* const build_commit = \"${commit}\";
}
")
set(before "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" before)
endif()
if(NOT before STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
