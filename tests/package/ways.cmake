# Run by CTest: every way of depending on the core but find_package(), which run.cmake tests.
#   cmake -DROOT=REPOSITORY -DWORK_DIR=… -DGENERATOR=… -DARGUMENTS=… -P ways.cmake
# ARGUMENTS go to CMake: a compiler, or a toolchain file.

file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${ROOT}/biss" DESTINATION "${WORK_DIR}/copied")
foreach(way IN ITEMS folder include repository fetch)
  set(source "${ROOT}")
  if(way STREQUAL "folder" OR way STREQUAL "include")
    set(source "${WORK_DIR}/copied")
  endif()
  execute_process(COMMAND "${CMAKE_COMMAND}" -S "${ROOT}/tests/package/ways" -G "${GENERATOR}"
                          -B "${WORK_DIR}/${way}" "-DWAY=${way}" "-DBISS_SOURCE=${source}"
                          ${ARGUMENTS}
                  COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK_DIR}/${way}"
                  COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output ECHO_ERROR_VARIABLE)
  message("${way}: ok")
endforeach()
