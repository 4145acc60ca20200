# The installed package: headers of the core and biss::core for find_package(biss), the C interface as
# biss::c, and the command.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Components: `core` has the headers of the core; `c` has the files to compile and link a C program;
# both have the package files. `c-runtime` has the shared library of the C interface, and `c` needs
# it. `c-sim` and `c-sim-runtime` are the same for the simulated line, and need `c` and `c-runtime`.
# `command` has the program with its manual page and its completion for bash, `python` the Python
# module, and `sigrok` the decoder for sigrok, which needs the module.
function(biss_install)
  set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/biss")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/biss" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
          COMPONENT core FILES_MATCHING PATTERN "*.hpp")
  install(TARGETS biss_core EXPORT biss COMPONENT core
          INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(EXPORT biss NAMESPACE biss:: FILE biss-targets.cmake DESTINATION "${package_dir}"
          COMPONENT core)
  configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/biss-config.cmake.in"
                                "${PROJECT_BINARY_DIR}/package/biss-config.cmake"
                                INSTALL_DESTINATION "${package_dir}")
  # Before 1.0 a minor version may change the interface. Headers do not depend on the word size.
  write_basic_package_version_file("${PROJECT_BINARY_DIR}/package/biss-config-version.cmake"
                                   COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
  foreach(part IN ITEMS core c)
    install(FILES "${PROJECT_BINARY_DIR}/package/biss-config.cmake"
                  "${PROJECT_BINARY_DIR}/package/biss-config-version.cmake"
            DESTINATION "${package_dir}" COMPONENT ${part})
  endforeach()
  if(TARGET biss_c)
    biss_install_c("${package_dir}" c biss biss_c biss_c_axis biss_c_control biss_c_frame biss_c_safety)
  endif()
  if(TARGET biss_c_sim)
    biss_install_c("${package_dir}" c_sim biss-sim biss_c_sim)
  endif()
  if(TARGET biss_command)
    install(TARGETS biss_command RUNTIME COMPONENT command)
    install(FILES "${PROJECT_BINARY_DIR}/biss.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1"
            COMPONENT command)
    install(FILES "${PROJECT_BINARY_DIR}/biss.bash" RENAME biss
            DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT command)
    # The page that make view has built; the command searches it there.
    install(FILES "${PROJECT_SOURCE_DIR}/view/dist/biss.html"
            DESTINATION "${CMAKE_INSTALL_DATADIR}/biss" COMPONENT command OPTIONAL)
  endif()
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/viewers/sigrok/biss"
          DESTINATION "${CMAKE_INSTALL_DATADIR}/libsigrokdecode/decoders" COMPONENT sigrok
          FILES_MATCHING PATTERN "*.py")
endfunction()

# One library of the C interface, static and shared, with its headers and its package file for
# pkg-config. Its targets are exported separately, so that each installed package is complete.
#   biss_install_c(PACKAGE_DIR NAME PC HEADER…): components NAME (with `-` for `_`) and NAME-runtime
function(biss_install_c package_dir name pc)
  string(REPLACE _ - part ${name})
  set(targets biss_${name})
  if(TARGET biss_${name}_shared)
    list(APPEND targets biss_${name}_shared)
  endif()
  foreach(header IN LISTS ARGN)
    install(FILES "${PROJECT_SOURCE_DIR}/capi/${header}.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT ${part})
  endforeach()
  install(TARGETS ${targets} EXPORT biss-${part}
          ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${part}
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${part}-runtime
                  NAMELINK_COMPONENT ${part}
          INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  install(EXPORT biss-${part} NAMESPACE biss:: FILE biss-${part}-targets.cmake
          DESTINATION "${package_dir}" COMPONENT ${part})
  # Written when the package is installed, because only then its prefix is known.
  set(known "set(PROJECT_VERSION \"${PROJECT_VERSION}\")\n")
  foreach(directory IN ITEMS libdir includedir)
    string(TOUPPER "CMAKE_INSTALL_${directory}" variable)
    set(path "${${variable}}")
    if(NOT IS_ABSOLUTE "${path}")
      string(PREPEND path "\${prefix}/")
    endif()
    string(APPEND known "set(pc_${directory} [[${path}]])\n")
  endforeach()
  set(from "${PROJECT_SOURCE_DIR}/cmake/${pc}.pc.in")
  set(to "${PROJECT_BINARY_DIR}/package/${pc}.pc")
  install(CODE "${known}configure_file(\"${from}\" \"${to}\" @ONLY)" COMPONENT ${part})
  install(FILES "${to}" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT ${part})
endfunction()

# Installs the libraries into an empty prefix, builds the project in tests/package against them and
# runs it.
function(biss_package_test)
  # A program that uses an instrumented library has to link the instrumentation.
  set(linker_flags "${CMAKE_EXE_LINKER_FLAGS}")
  if(BISS_COVERAGE)
    string(APPEND linker_flags " -fprofile-instr-generate")
  endif()
  add_test(NAME Package.SecondProject_FindsBuildsAndRuns
           COMMAND "${CMAKE_COMMAND}"
                   "-DBUILD_DIR=${PROJECT_BINARY_DIR}"
                   "-DSOURCE_DIR=${PROJECT_SOURCE_DIR}/tests/package"
                   "-DWORK_DIR=${PROJECT_BINARY_DIR}/package-test"
                   "-DGENERATOR=${CMAKE_GENERATOR}"
                   "-DCOMPILER=${CMAKE_CXX_COMPILER}"
                   "-DFLAGS=${CMAKE_CXX_FLAGS}"
                   "-DLINKER_FLAGS=${linker_flags}"
                   "-DVERSION=${PROJECT_VERSION}"
                   "-DBUILD_TYPE=${CMAKE_BUILD_TYPE}"
                   -P "${PROJECT_SOURCE_DIR}/tests/package/run.cmake")
  add_test(NAME Package.EachWayOfDepending_CompilesAgainstTheHeadersAlone
           COMMAND "${CMAKE_COMMAND}"
                   "-DROOT=${PROJECT_SOURCE_DIR}"
                   "-DWORK_DIR=${PROJECT_BINARY_DIR}/package-ways"
                   "-DGENERATOR=${CMAKE_GENERATOR}"
                   "-DARGUMENTS=-DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}"
                   -P "${PROJECT_SOURCE_DIR}/tests/package/ways.cmake")
endfunction()
