# cmake -DCOMPILER=… -DROOT=… -P wrong_plans.cmake: does wrong_plans.cpp fail to compile for the
# reasons that it names, and for no others?
set(source "${ROOT}/tests/core/wrong_plans.cpp")
execute_process(
  COMMAND ${COMPILER} -std=c++20 "-I${ROOT}" -fsyntax-only "${source}"
  RESULT_VARIABLE status
  ERROR_VARIABLE said)
if(status EQUAL 0)
  message(FATAL_ERROR "wrong_plans.cpp compiles")
endif()
file(STRINGS "${source}" sentences REGEX "^// says: ")
list(LENGTH sentences count)
if(NOT count EQUAL 18)
  message(FATAL_ERROR "${count} sentences, not one for each SafetySetupError and one for the name")
endif()
foreach(sentence IN LISTS sentences)
  string(REPLACE "// says: " "" sentence "${sentence}")
  string(FIND "${said}" "${sentence}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "the compiler does not print \"${sentence}\" but\n${said}")
  endif()
endforeach()
# The static assertions once each: a plan has one mistake and hears of no other.
string(REGEX MATCHALL "error: static[_ ]assert[a-z]* failed" failed "${said}")
list(LENGTH failed count)
if(NOT count EQUAL 17)
  message(FATAL_ERROR "${count} static assertions failed, not 17:\n${said}")
endif()
