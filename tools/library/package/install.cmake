# cmake --install: the library, its headers, the command, and what finds them from a prefix that may be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

add_library(weft::weft ALIAS weft_library)
set_target_properties(weft_library PROPERTIES EXPORT_NAME weft)
target_compile_features(weft_library INTERFACE cxx_std_20)

file(RELATIVE_PATH WEFT_BIN_TO_LIB /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
set_target_properties(weft PROPERTIES INSTALL_RPATH "$ORIGIN/${WEFT_BIN_TO_LIB}")

install(TARGETS weft_library EXPORT weftTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
# Loaded by name, so not among the libraries that programs link. They serve the library's copies for some processors too.
if(NOT WEFT_IS_COPY)
  get_property(parts GLOBAL PROPERTY WEFT_PARTS)
  install(TARGETS ${parts} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/weft COMPONENT library)
endif()
install(TARGETS weft RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/library/include/weft ${PROJECT_SOURCE_DIR}/meshing/include/weft
  ${PROJECT_SOURCE_DIR}/tools/bindings/c/include/weft
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/LICENSE.GPL ${PROJECT_SOURCE_DIR}/README.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT papers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/weft)
install(EXPORT weftTargets NAMESPACE weft:: DESTINATION ${package_folder} COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/weftConfig.cmake.in
  ${PROJECT_BINARY_DIR}/weftConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/weftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/weftConfig.cmake ${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT development)

# pkg-config finds the prefix from where the file lies.
file(RELATIVE_PATH WEFT_PC_TO_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
if(MPI_C_HEADER_DIR MATCHES mpich OR MPI_C_INCLUDE_DIRS MATCHES mpich)
  set(WEFT_MPI_PACKAGE mpich)
else()
  set(WEFT_MPI_PACKAGE ompi-c)
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/weft.pc.in ${PROJECT_BINARY_DIR}/weft.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/weft.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
