# The installed package: headers of the core and biss::core for find_package(biss), the C interface as
# biss::c, and the command.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Component `core` is the headers and the package files, `c` the C interface, `command` the program
# with its manual page and its completion for bash.
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
  # Before 1.0 a minor version may change the interface. Headers know no word size.
  write_basic_package_version_file("${PROJECT_BINARY_DIR}/package/biss-config-version.cmake"
                                   COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
  install(FILES "${PROJECT_BINARY_DIR}/package/biss-config.cmake"
                "${PROJECT_BINARY_DIR}/package/biss-config-version.cmake"
          DESTINATION "${package_dir}" COMPONENT core)
  if(TARGET biss_c)
    # Exported apart, so that the core alone is a whole package.
    install(FILES "${PROJECT_SOURCE_DIR}/capi/biss_c.h" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
            COMPONENT c)
    install(TARGETS biss_c EXPORT biss-c ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT c
            INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
    install(EXPORT biss-c NAMESPACE biss:: FILE biss-c-targets.cmake DESTINATION "${package_dir}"
            COMPONENT c)
  endif()
  if(TARGET biss_command)
    install(TARGETS biss_command RUNTIME COMPONENT command)
    install(FILES "${PROJECT_BINARY_DIR}/biss.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1"
            COMPONENT command)
    install(FILES "${PROJECT_BINARY_DIR}/biss.bash" RENAME biss
            DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT command)
    # Where make view has built it; the command looks for it there.
    install(FILES "${PROJECT_SOURCE_DIR}/view/dist/biss.html"
            DESTINATION "${CMAKE_INSTALL_DATADIR}/biss" COMPONENT command OPTIONAL)
  endif()
endfunction()

# Installs the libraries into an empty prefix, builds the project in tests/package against them and
# runs it.
function(biss_package_test)
  # What the library is instrumented with, its user has to link.
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
                   -P "${PROJECT_SOURCE_DIR}/tests/package/run.cmake")
  add_test(NAME Package.EachWayOfDepending_CompilesAgainstTheHeadersAlone
           COMMAND "${CMAKE_COMMAND}"
                   "-DROOT=${PROJECT_SOURCE_DIR}"
                   "-DWORK_DIR=${PROJECT_BINARY_DIR}/package-ways"
                   "-DGENERATOR=${CMAKE_GENERATOR}"
                   "-DARGUMENTS=-DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}"
                   -P "${PROJECT_SOURCE_DIR}/tests/package/ways.cmake")
endfunction()
