# One target a room, its sources listed, its arrows as link libraries.
#
#   biss_room(capture SOURCES vcd_reader.cpp … LINKS biss_wire fmt::fmt)   -> target biss_capture
#   biss_room_test(capture vcd_reader_test.cpp …)                          -> target biss_capture_test, in CTest

add_library(biss_flags INTERFACE)
target_compile_features(biss_flags INTERFACE cxx_std_20)
target_compile_options(biss_flags INTERFACE -Wall -Wextra -Wconversion -Wsign-conversion -Wshadow
                                            -Werror)
# GCC 12 sees overlapping copies in every std::string assignment at -O3 (GCC bug 105651).
target_compile_options(biss_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(BISS_COVERAGE)
  target_compile_options(biss_flags INTERFACE -fprofile-instr-generate -fcoverage-mapping)
  target_link_options(biss_flags INTERFACE -fprofile-instr-generate)
endif()

# A library of the given sources; without sources an interface of its headers.
function(biss_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "" "SOURCES;LINKS")
  if(room_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "biss_room(${name}): unexpected ${room_UNPARSED_ARGUMENTS}")
  endif()
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

# For targets whose own files take longer to compile than to run; see BISS_COLD_OPTIONS.
function(biss_cold)
  foreach(target IN LISTS ARGN)
    if(TARGET ${target})
      target_compile_options(${target} PRIVATE ${BISS_COLD_OPTIONS})
    endif()
  endforeach()
endfunction()

# The room's unit tests, one CTest a case, labelled with the room's name.
function(biss_room_test name)
  if(NOT BISS_TESTS)
    return()
  endif()
  add_executable(biss_${name}_test ${ARGN})
  target_link_libraries(biss_${name}_test PRIVATE biss_${name} biss_flags GTest::gtest
                                                  GTest::gmock GTest::gtest_main)
  gtest_discover_tests(biss_${name}_test DISCOVERY_TIMEOUT 60 PROPERTIES LABELS ${name})
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
  target_compile_options(biss_core_headers PRIVATE -ffreestanding -fno-exceptions -fno-rtti)
endfunction()
