# What `cmake --install` lays out: both libraries, the scene library, the headers, the command line, and the
# two ways to find them: find_package(percale) and pkg-config.

set_target_properties(percale_shared PROPERTIES EXPORT_NAME percale)
set_target_properties(percale_scene PROPERTIES EXPORT_NAME scene)
install(TARGETS percale_static percale_shared percale_scene percale_cli EXPORT percale-targets)
install(DIRECTORY include/percale TYPE INCLUDE)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/percale)
install(EXPORT percale-targets NAMESPACE percale:: DESTINATION ${package_folder})
configure_package_config_file(cmake/percale-config.cmake.in percale-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(percale-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/percale-config.cmake ${PROJECT_BINARY_DIR}/percale-config-version.cmake
        DESTINATION ${package_folder})

file(RELATIVE_PATH PREFIX_FROM_PKGCONFIG ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/percale.pc.in percale.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/percale.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
