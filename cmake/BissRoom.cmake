# One target a room, its sources listed, its arrows as link libraries.
#
#   biss_room(capture SOURCES vcd_reader.cpp … LINKS biss_wire fmt::fmt)   -> target biss_capture
#   biss_room_test(capture vcd_reader_test.cpp …)                          -> target biss_capture_test, in CTest

add_library(biss_flags INTERFACE)
target_compile_features(biss_flags INTERFACE cxx_std_20)
target_compile_options(biss_flags INTERFACE -Wall -Wextra -Wconversion -Wsign-conversion -Wshadow
                                            -Werror)
if(BISS_COVERAGE)
  target_compile_options(biss_flags INTERFACE -fprofile-instr-generate -fcoverage-mapping)
  target_link_options(biss_flags INTERFACE -fprofile-instr-generate)
endif()

function(biss_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "" "SOURCES;LINKS")
  if(room_SOURCES)
    add_library(biss_${name} STATIC ${room_SOURCES})
    target_include_directories(biss_${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(biss_${name} PUBLIC ${room_LINKS} PRIVATE biss_flags)
    target_compile_features(biss_${name} PUBLIC cxx_std_20)
  else()
    add_library(biss_${name} INTERFACE)
    target_include_directories(biss_${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(biss_${name} INTERFACE ${room_LINKS})
  endif()
endfunction()

function(biss_room_test name)
  if(NOT BISS_TESTS)
    return()
  endif()
  add_executable(biss_${name}_test ${ARGN})
  target_link_libraries(biss_${name}_test PRIVATE biss_${name} biss_flags GTest::gtest
                                                  GTest::gmock GTest::gtest_main)
  gtest_discover_tests(biss_${name}_test DISCOVERY_TIMEOUT 60)
endfunction()
