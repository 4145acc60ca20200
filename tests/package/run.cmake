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

# The C interface alone.
set(prefix_of_c "${WORK_DIR}/prefix-c")
foreach(component c-runtime c)
  step("install ${component} alone" "${CMAKE_COMMAND}" --install "${BUILD_DIR}"
       --prefix "${prefix_of_c}" --component "${component}")
endforeach()
step("configure without the core" ${configure} -B "${WORK_DIR}/user-c" "-DBISS_WANTED=${VERSION}"
     "-DCMAKE_PREFIX_PATH=${prefix_of_c}" -DBISS_COMPONENTS=c)
step("build without the core" "${CMAKE_COMMAND}" --build "${WORK_DIR}/user-c")
step("run without the core" "${WORK_DIR}/user-c/c_shared_user")

# Libraries in an absolute folder: pkg-config does not look for it in the prefix.
set(absolute "${WORK_DIR}/absolute")
step("configure with an absolute folder" "${CMAKE_COMMAND}" -S "${SOURCE_DIR}/../.." -B "${absolute}"
     -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${COMPILER}" -DBISS_TESTS=OFF
     -DCMAKE_INSTALL_LIBDIR=/opt/biss/lib)
file(GLOB built "${BUILD_DIR}/capi/libbiss_c.*")
file(COPY ${built} DESTINATION "${absolute}/capi")
step("install c in an absolute folder" "${CMAKE_COMMAND}" -E env "DESTDIR=${absolute}/root"
     "${CMAKE_COMMAND}" --install "${absolute}" --prefix /usr --component c)
file(STRINGS "${absolute}/root/opt/biss/lib/pkgconfig/biss.pc" folders REGEX "dir=")
if(NOT folders STREQUAL "libdir=/opt/biss/lib;includedir=\${prefix}/include")
  message(FATAL_ERROR "biss.pc has the folders ${folders}")
endif()

# The version file refuses other versions.
execute_process(COMMAND ${configure} -B "${WORK_DIR}/other-version" -DBISS_WANTED=99.0
                RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(status EQUAL 0)
  message(FATAL_ERROR "a project asking for version 99.0 was given ${VERSION}:\n${output}")
endif()
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(NOT output MATCHES "compatible with requested version \"99.0\"")
  message(FATAL_ERROR "version 99.0 was refused, but for another reason:\n${output}")
endif()
