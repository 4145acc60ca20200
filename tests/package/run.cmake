# Run by CTest, see biss_package_test(). Fails with the output of the step that failed.

function(step what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${output}")
  endif()
  message("${what}: ok")
endfunction()

set(prefix "${WORK_DIR}/prefix")
set(user "${WORK_DIR}/user")
set(configure "${CMAKE_COMMAND}" -S "${SOURCE_DIR}" -G "${GENERATOR}"
              "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_FLAGS=${FLAGS}"
              "-DCMAKE_EXE_LINKER_FLAGS=${LINKER_FLAGS}" "-DCMAKE_PREFIX_PATH=${prefix}"
              -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF)

# Nothing of an earlier run may help this one.
file(REMOVE_RECURSE "${WORK_DIR}")

foreach(component core c-runtime c c-sim-runtime c-sim)
  step("install ${component}" "${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${prefix}"
       --component "${component}")
endforeach()
step("configure" ${configure} -B "${user}" "-DBISS_WANTED=${VERSION}")
step("build" "${CMAKE_COMMAND}" --build "${user}")
step("run" "${user}/user")
step("run from C" "${user}/c_user")
step("run from C with the shared library" "${user}/c_shared_user")
# Instrumented libraries need what the program is linked with.
if(NOT FLAGS MATCHES "-fsanitize" AND NOT LINKER_FLAGS MATCHES "instr-generate")
  if(BUILD_TYPE STREQUAL "Release")
    set(optimised optimised)
  endif()
  step("shared library" "${SOURCE_DIR}/shared_library" "${prefix}" "${WORK_DIR}" "${VERSION}"
       ${optimised})
endif()

# The version file says no to what this version is not.
execute_process(COMMAND ${configure} -B "${WORK_DIR}/other-version" -DBISS_WANTED=99.0
                RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(status EQUAL 0)
  message(FATAL_ERROR "a project asking for version 99.0 was given ${VERSION}:\n${output}")
endif()
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(NOT output MATCHES "compatible with requested version \"99.0\"")
  message(FATAL_ERROR "version 99.0 was refused, but for another reason:\n${output}")
endif()
