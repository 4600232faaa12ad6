# Debian packages by CPack, one a component: scripts/package.sh builds and checks them. Included last, when all that is
# installed is known.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME weft)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_VENDOR weft)
set(CPACK_PACKAGE_CONTACT "weft maintainers <maintainers@weft.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_OUTPUT_FILE_PREFIX packages)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# weft_package(COMPONENT PACKAGE SECTION SUMMARY TEXT DEPENDS [LIBRARY]): the files of a component as a package, of section
# libs with the name of the shared library in it. CPack would name one twice that has a copy for some processors.
function(weft_package component package section summary text depends)
  string(TOUPPER ${component} upper)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  if(section STREQUAL libs)
    set(shlibs ${PROJECT_BINARY_DIR}/${package}/shlibs)
    file(WRITE ${shlibs} "${ARGN} ${PROJECT_VERSION_MAJOR} ${package} (= ${PROJECT_VERSION}-1)\n")
    file(CHMOD ${shlibs} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
    set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/tools/packaging/triggers;${shlibs}" PARENT_SCOPE)
  endif()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  install(FILES ${PROJECT_SOURCE_DIR}/tools/packaging/copyright DESTINATION share/doc/${package} COMPONENT ${component})
  install(FILES ${PROJECT_BINARY_DIR}/changelog.Debian.gz DESTINATION share/doc/${package} COMPONENT ${component})
endfunction()

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${PROJECT_BINARY_DIR}/changelog.Debian "weft (${PROJECT_VERSION}-1) unstable; urgency=medium\n\n\
  * This package was built from the sources; what is new: CHANGELOG.md.\n\n\
 -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
execute_process(COMMAND gzip -9nf ${PROJECT_BINARY_DIR}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)

set(about "Takes a tetrahedral mesh and a metric, wanted sizes and stretching at\n\
every vertex, and returns a mesh whose edges have unit length in the\n\
metric. Runs on all cores of one machine and on clusters over MPI.")
set(CPACK_COMPONENTS_ALL)
weft_package(library libweft${PROJECT_VERSION_MAJOR} libs "anisotropic tetrahedral mesh adaptation: library"
  "${about}\n.\nThis package has the shared library, with its C++ and C interfaces." "" libweft)
weft_package(development libweft-dev libdevel "anisotropic tetrahedral mesh adaptation: headers"
  "${about}\n.\nThis package has the headers and what CMake and pkg-config need."
  "libweft${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}-1), libopenmpi-dev")
weft_package(command weft science "anisotropic tetrahedral mesh adaptation: command"
  "${about}\n.\nThis package has the command, with man pages and completion for shells."
  "libweft${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}-1), openmpi-bin")
if(TARGET weft_petsc)
  weft_package(petsc libweft-petsc${PROJECT_VERSION_MAJOR} libs "anisotropic tetrahedral mesh adaptation: for PETSc"
    "${about}\n.\nThis package makes it a mesh adaptor of PETSc (-dm_adaptor weft)."
    "libweft${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}-1)" libweft_petsc)
endif()
if(TARGET weft_fortran)
  weft_package(fortran libweft-fortran-dev libdevel "anisotropic tetrahedral mesh adaptation: Fortran module"
    "${about}\n.\nThis package has the module for Fortran, a static library over libweft."
    "libweft-dev (= ${PROJECT_VERSION}-1)")
endif()
if(TARGET weft_python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-mpi4py, python3-meshio")
  weft_package(python python3-weft python "anisotropic tetrahedral mesh adaptation: Python module"
    "${about}\n.\nThis package has the module for Python 3, on NumPy arrays."
    "libweft${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}-1), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
endif()
include(CPack)
