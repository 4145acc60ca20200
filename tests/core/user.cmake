# cmake -DCOMPILER=… -DROOT=… -DWORK_DIR=… -P user.cmake: does user.cpp compile with every header of
# the core in it, without a warning, and does its object hold nothing of the tables it only reads
# while compiling?
file(GLOB_RECURSE headers RELATIVE "${ROOT}" "${ROOT}/biss/*.hpp")
list(TRANSFORM headers REPLACE "(.+)" "#include \"\\1\"")
list(JOIN headers "\n" headers)
file(READ "${ROOT}/tests/core/user.cpp" text)
string(REPLACE "// user.cmake inserts every header of the core here." "${headers}" with_headers "${text}")
if(with_headers STREQUAL text)
  message(FATAL_ERROR "user.cpp has no place for the headers")
endif()
file(WRITE "${WORK_DIR}/user.cpp" "${with_headers}")
set(warnings -Wall -Wextra -Wconversion -Wsign-conversion -Wshadow -Werror)
execute_process(COMMAND ${COMPILER} -std=c++20 -fno-exceptions -fno-rtti ${warnings} "-I${ROOT}"
                        -DSTANDARD_FIRST -fsyntax-only "${WORK_DIR}/user.cpp"
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${COMPILER} -std=c++20 -fno-exceptions -fno-rtti ${warnings} "-I${ROOT}" -Os
                        -c "${WORK_DIR}/user.cpp" -o "${WORK_DIR}/user.o"
                COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS "${WORK_DIR}/user.o" stored REGEX "resolute-18|fortis-36|ic-mhm|rlh|iC-PVS|MT_LEN")
if(stored)
  message(FATAL_ERROR "the object holds names of tables that nothing uses: ${stored}")
endif()
