# cmake -DCOMPILER=… -DROOT=… -P wrong_names.cmake: does wrong_names.cpp fail to compile for the
# reasons that it names, one error each? And does C++17 end with one sentence?
set(source "${ROOT}/tests/core/wrong_names.cpp")
execute_process(COMMAND ${COMPILER} -std=c++20 "-I${ROOT}" -fsyntax-only "${source}"
                RESULT_VARIABLE status ERROR_VARIABLE said)
if(status EQUAL 0)
  message(FATAL_ERROR "wrong_names.cpp compiles")
endif()
file(STRINGS "${source}" words REGEX "^// says: ")
foreach(word IN LISTS words)
  string(REPLACE "// says: " "" word "${word}")
  string(FIND "${said}" "${word}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "the compiler does not print \"${word}\" but\n${said}")
  endif()
endforeach()
# Clang reports the uninitialised variable as a separate error.
list(LENGTH words count)
math(EXPR most "2 * ${count}")
string(REGEX MATCHALL "error: " errors "${said}")
list(LENGTH errors errors)
if(count EQUAL 0 OR errors GREATER most)
  message(FATAL_ERROR "${errors} errors for ${count} mistakes:\n${said}")
endif()

execute_process(COMMAND ${COMPILER} -std=c++17 "-I${ROOT}" -fsyntax-only -x c++
                        "${ROOT}/biss/safety/monitor.hpp"
                RESULT_VARIABLE status ERROR_VARIABLE said)
string(REGEX MATCHALL "error: " errors "${said}")
list(LENGTH errors errors)
if(status EQUAL 0 OR NOT said MATCHES "biss needs C\\+\\+20" OR errors GREATER 2)
  message(FATAL_ERROR "C++17 is refused with ${errors} errors:\n${said}")
endif()
