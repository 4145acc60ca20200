# cmake -DCOMPILER=… -DROOT=… -P wrong_mistakes.cmake: does each mistake of wrong_mistakes.cpp fail
# to compile, with its message, and does the rest compile?
set(source "${ROOT}/tests/core/wrong_mistakes.cpp")
set(ENV{LC_ALL} C)
file(STRINGS "${source}" words REGEX "^// says: ")
set(number 0)
list(PREPEND words "")
foreach(word IN LISTS words)
  execute_process(COMMAND ${COMPILER} -std=c++20 "-I${ROOT}" -DMISTAKE=${number} -fsyntax-only
                          "${source}"
                  RESULT_VARIABLE status ERROR_VARIABLE said)
  string(REPLACE "// says: " "" word "${word}")
  string(FIND "${said}" "${word}" at)
  if(number EQUAL 0 AND NOT status EQUAL 0)
    message(FATAL_ERROR "without a mistake it does not compile:\n${said}")
  elseif(NOT number EQUAL 0 AND (status EQUAL 0 OR at EQUAL -1))
    message(FATAL_ERROR "mistake ${number}: the compiler does not print \"${word}\" but\n${said}")
  endif()
  math(EXPR number "${number} + 1")
endforeach()
if(number LESS 10)
  message(FATAL_ERROR "only ${number} mistakes")
endif()
