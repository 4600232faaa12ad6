# The library once more, for processors of level x86-64-v4 (AVX-512). glibc's loader looks into this folder first, and takes what is
# there where the processor can run it; programs are the same.
include(ExternalProject)
include(GNUInstallDirs)
set(WEFT_V4_FOLDER ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/glibc-hwcaps/x86-64-v4)
set(v4_options)
foreach(option CMAKE_BUILD_TYPE CMAKE_C_COMPILER CMAKE_CXX_COMPILER CMAKE_CXX_COMPILER_LAUNCHER MPI_C_COMPILER WEFT_ASSERTIONS WEFT_WERROR
        CMAKE_SKIP_INSTALL_RPATH)
  if(DEFINED ${option})
    list(APPEND v4_options -D${option}=${${option}})
  endif()
endforeach()
ExternalProject_Add(weft_v4
  SOURCE_DIR ${PROJECT_SOURCE_DIR}
  BINARY_DIR ${PROJECT_BINARY_DIR}/v4
  CMAKE_ARGS ${v4_options} -DWEFT_ARCH=x86-64-v4 -DWEFT_LEVELS=OFF -DWEFT_TESTS=OFF -DWEFT_PYTHON=OFF -DWEFT_FORTRAN=OFF
    -DWEFT_LIBRARY_FOLDER=${WEFT_V4_FOLDER} -DCMAKE_INSTALL_LIBDIR=${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/x86-64-v4 -DWEFT_IS_COPY=ON
  BUILD_COMMAND ${CMAKE_COMMAND} --build . --target weft_library
  INSTALL_COMMAND ""
  BUILD_ALWAYS TRUE
  USES_TERMINAL_BUILD TRUE)
# Its own installation strips it and leaves search paths out, as lintian wants; files that are copied from a build keep both.
install(CODE "
  set(strip)
  if(CMAKE_INSTALL_DO_STRIP)
    set(strip --strip)
  endif()
  execute_process(COMMAND \"${CMAKE_COMMAND}\" --install \"${PROJECT_BINARY_DIR}/v4\" --component library
    --prefix \"\${CMAKE_INSTALL_PREFIX}\" \${strip} COMMAND_ERROR_IS_FATAL ANY)"
  COMPONENT library)
