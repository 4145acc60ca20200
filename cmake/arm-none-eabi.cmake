# Bare Cortex-M with Debian's gcc-arm-none-eabi. BISS_CPU names the core: cortex-m4, cortex-m0, ….
#
#   cmake --preset cortex-m4          or          cmake --toolchain cmake/arm-none-eabi.cmake -DBISS_CPU=cortex-m0 …
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)

set(BISS_CPU "cortex-m4" CACHE STRING "The -mcpu of the target")
# try_compile runs this file again in a separate project.
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES BISS_CPU)

set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_ASM_COMPILER arm-none-eabi-gcc)

# There is no start-up code at the time CMake probes the compiler, so it may not link.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# Soft floats on every processor: the library's core uses no floating point, and one ABI serves all
# processors.
set(biss_machine "-mcpu=${BISS_CPU} -mthumb -mfloat-abi=soft -ffunction-sections -fdata-sections")
set(CMAKE_C_FLAGS_INIT "${biss_machine}")
set(CMAKE_ASM_FLAGS_INIT "${biss_machine}")
set(CMAKE_CXX_FLAGS_INIT
    "${biss_machine} -ffreestanding -fno-exceptions -fno-rtti -fno-threadsafe-statics")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,--gc-sections")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
