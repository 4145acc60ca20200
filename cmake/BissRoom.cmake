# One target a room, its sources listed, its arrows as link libraries.
#
#   biss_room(capture SOURCES vcd_reader.cpp … LINKS biss_wire fmt::fmt)   -> target biss_capture
#   biss_room_test(capture vcd_reader_test.cpp …)                          -> target biss_capture_test, in CTest

add_library(biss_flags INTERFACE)
target_compile_features(biss_flags INTERFACE cxx_std_20)
target_compile_options(biss_flags INTERFACE -Wall -Wextra -Wconversion -Wsign-conversion -Wshadow
                                            -Werror)
# GCC 12 sees overlapping copies and accesses past the end in std::string and std::vector (GCC bugs
# 105651 and 105329).
target_compile_options(biss_flags INTERFACE
                       $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)
if(BISS_COVERAGE)
  target_compile_options(biss_flags INTERFACE -fprofile-instr-generate -fcoverage-mapping)
  target_link_options(biss_flags INTERFACE -fprofile-instr-generate)
endif()

# Two measures halve the time of a build, most of which went into parsing and instantiating headers.
# The headers below are parsed once for all rooms of a kind and once for all tests. The release build
# joins up to 32 source files of a target into one (CMAKE_UNITY_BUILD), of verbs up to 26:
# a name that only one file uses has to be unique within its target, and a test file keeps its names
# in a separate namespace.
set(biss_common_headers
    <algorithm> <array> <bit> <charconv> <cstdint> <functional> <memory> <optional> <span> <string>
    <string_view> <utility> <variant> <vector> <fmt/format.h> <fmt/ranges.h> <tl/expected.hpp>
    "${PROJECT_SOURCE_DIR}/biss/frame/decode.hpp")

# biss_kind(TARGET room|cold|test): TARGET uses the common headers, a test also the headers of
# GoogleTest, and the compiler options of its kind: BISS_COLD_OPTIONS, BISS_TEST_OPTIONS.
function(biss_kind target kind)
  string(TOUPPER ${kind} upper)
  if(NOT TARGET biss_${kind}_headers)
    file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/${kind}_headers.cpp" CONTENT "// No code.\n")
    add_library(biss_${kind}_headers OBJECT "${PROJECT_BINARY_DIR}/${kind}_headers.cpp")
    target_link_libraries(biss_${kind}_headers PRIVATE biss_core biss_flags fmt::fmt)
    set(headers ${biss_common_headers})
    if(kind STREQUAL test)
      target_link_libraries(biss_test_headers PRIVATE GTest::gtest GTest::gmock)
      list(APPEND headers <gtest/gtest.h> <gmock/gmock.h>)
    endif()
    target_compile_options(biss_${kind}_headers PRIVATE ${BISS_${upper}_OPTIONS})
    target_precompile_headers(biss_${kind}_headers PRIVATE ${headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM biss_${kind}_headers)
  target_compile_options(${target} PRIVATE ${BISS_${upper}_OPTIONS})
  target_link_libraries(${target} PRIVATE biss_core fmt::fmt nlohmann_json::nlohmann_json)
endfunction()

# A library of the given sources; without sources an interface of its headers. COLD: code that no
# user waits for. It is compiled with BISS_COLD_OPTIONS: in the release build in 0.6 of the time of
# -O2.
function(biss_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "COLD" "" "SOURCES;LINKS")
  if(room_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "biss_room(${name}): unexpected ${room_UNPARSED_ARGUMENTS}")
  endif()
  if(room_SOURCES)
    add_library(biss_${name} STATIC ${room_SOURCES})
    target_include_directories(biss_${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(biss_${name} PUBLIC ${room_LINKS} PRIVATE biss_flags)
    target_compile_features(biss_${name} PUBLIC cxx_std_20)
    if(room_COLD)
      biss_kind(biss_${name} cold)
    elseif(NOT name STREQUAL oracle)
      biss_kind(biss_${name} room)
    endif()
  else()
    add_library(biss_${name} INTERFACE)
    target_include_directories(biss_${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(biss_${name} INTERFACE ${room_LINKS})
  endif()
endfunction()

# A template or inline function that several rooms use is linked from the first object that has it.
# Therefore the rooms that are compiled for speed come first in TARGET: a copy of a cold room is
# slower by a quarter.
function(biss_fast_rooms_first target)
  foreach(room IN ITEMS sim decode capture flow identify lab)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:biss_${room}>)
  endforeach()
endfunction()

# biss_simd(FILE…): files of a room that Highway compiles once for each SIMD level: alone, and at full
# optimisation.
function(biss_simd)
  set_source_files_properties(${ARGN} PROPERTIES
                              SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON
                              COMPILE_OPTIONS "$<$<CONFIG:Release>:-O3>")
endfunction()

# biss_tests(PROGRAM LABEL [SHARDS]): the cases of a GoogleTest program in 4 or SHARDS CTests. One for
# each case would start the programs a thousand times. The environment's GTEST_FILTER selects cases.
function(biss_tests program label)
  list(APPEND ARGN 4)
  list(GET ARGN 0 shards)
  math(EXPR last "${shards} - 1")
  foreach(shard RANGE ${last})
    add_test(NAME ${program}_${shard} COMMAND ${program} --gtest_brief=1)
    set_tests_properties(${program}_${shard} PROPERTIES LABELS ${label} ENVIRONMENT
                         "GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()

# biss_room_test(NAME [LONG] SOURCE…): the room's unit tests, labelled with the room's name. LONG
# tests take minutes: they are labelled `long`, built with BISS_LONG_TESTS, and optimised like a
# room. Others try more if the environment has BISS_LONG: tests/common/long_run.hpp.
function(biss_room_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "LONG" "" "")
  if(NOT BISS_TESTS OR (test_LONG AND NOT BISS_LONG_TESTS))
    return()
  endif()
  if(name MATCHES "^(capture|dump|decode)$" AND NOT BISS_BYTE_TESTS)
    return()
  endif()
  set(label ${name})
  if(test_LONG)
    set(label long)
  endif()
  add_executable(biss_${name}_test ${test_UNPARSED_ARGUMENTS})
  target_link_libraries(biss_${name}_test PRIVATE biss_${name} biss_flags GTest::gtest
                                                  GTest::gmock GTest::gtest_main)
  if(NOT test_LONG)
    biss_kind(biss_${name}_test test)
  endif()
  biss_tests(biss_${name}_test ${label})
endfunction()

# Compiles every header of the core alone, as firmware would. Found by pattern and not listed,
# because the check must find a header that is in no list.
function(biss_core_header_check)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}"
       "${PROJECT_SOURCE_DIR}/biss/*.hpp")
  set(units "")
  foreach(header IN LISTS headers)
    set(unit "${PROJECT_BINARY_DIR}/header-check/${header}.cpp")
    # Twice: the second one shows that the guard works.
    file(CONFIGURE OUTPUT "${unit}" CONTENT "#include \"${header}\"\n#include \"${header}\"\n")
    list(APPEND units "${unit}")
  endforeach()
  add_library(biss_core_headers OBJECT ${units})
  target_link_libraries(biss_core_headers PRIVATE biss_core biss_flags)
  set_target_properties(biss_core_headers PROPERTIES UNITY_BUILD OFF)
  target_compile_options(biss_core_headers PRIVATE -ffreestanding -fno-exceptions -fno-rtti)
endfunction()
