# Makes the libraries of interface packages independent of the folder in which they are built.
#
# * They find each other without LD_LIBRARY_PATH, also when the workspace is moved or when they are
#   installed from a wheel: their RUNPATH is relative.
# * rosidl_typesupport_c opens the libraries of the implementations by name. The dynamic loader
#   finds only those that are loaded already, unless their folder is on LD_LIBRARY_PATH: the
#   extension module that Python imports first loads them.
# * They have the same bytes wherever they are built.

# The folders of the libraries of packages in this workspace, relative to `from`.
function(_launcher_sibling_folders result from)
  get_filename_component(base "${CMAKE_INSTALL_PREFIX}" DIRECTORY)
  set(folders "")
  set(layout "")
  if(EXISTS "${base}/.colcon_install_layout")
    file(STRINGS "${base}/.colcon_install_layout" layout)
  endif()
  if(layout STREQUAL "isolated")
    file(TO_CMAKE_PATH "$ENV{CMAKE_PREFIX_PATH}" prefixes)
    foreach(prefix IN LISTS prefixes)
      get_filename_component(parent "${prefix}" DIRECTORY)
      get_filename_component(name "${prefix}" NAME)
      if(parent STREQUAL base AND NOT prefix STREQUAL CMAKE_INSTALL_PREFIX)
        list(APPEND folders "${from}/../../${name}/lib")
      endif()
    endforeach()
    list(SORT folders)
    list(REMOVE_DUPLICATES folders)
  endif()
  set(${result} "${folders}" PARENT_SCOPE)
endfunction()

function(_launcher_relocate_interface_libraries)
  get_property(targets DIRECTORY PROPERTY BUILDSYSTEM_TARGETS)
  set(implementations "")
  set(dispatchers "")
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "SHARED_LIBRARY" AND target MATCHES "__rosidl_(generator|typesupport)_")
      _launcher_sibling_folders(siblings "$ORIGIN")
      set(folders "$ORIGIN" ${siblings})
    elseif(type STREQUAL "MODULE_LIBRARY" AND target MATCHES "_s__rosidl_typesupport_")
      set(folders "$ORIGIN/../../..")  # of lib/pythonX.Y/site-packages/PACKAGE
    else()
      continue()
    endif()
    set_target_properties(${target} PROPERTIES
      INSTALL_RPATH "${folders}" BUILD_WITH_INSTALL_RPATH TRUE)
    target_link_options(${target} PRIVATE "$<$<CONFIG:Release,MinSizeRel>:-s>")
    if(target MATCHES "__rosidl_typesupport_(fastrtps|introspection)_c$" AND NOT target MATCHES "_s__")
      list(APPEND implementations ${target})
    elseif(target MATCHES "_s__rosidl_typesupport_c$")
      list(APPEND dispatchers ${target})
    elseif(target MATCHES "__rosidl_generator_py$")
      # Exported, they would name the Python of this machine; a package that builds upon this one
      # adds its own.
      get_target_property(includes ${target} INTERFACE_INCLUDE_DIRECTORIES)
      if(includes)
        set_target_properties(${target} PROPERTIES
          INTERFACE_INCLUDE_DIRECTORIES "$<BUILD_INTERFACE:${includes}>")
      endif()
    endif()
  endforeach()
  foreach(dispatcher IN LISTS dispatchers)
    target_link_libraries(${dispatcher} PRIVATE
      "-Wl,--no-as-needed" ${implementations} "-Wl,--as-needed")
  endforeach()
endfunction()

# `__FILE__`, which assertions contain, and debug information name the folders.
add_compile_options(
  "-ffile-prefix-map=${CMAKE_SOURCE_DIR}=."
  "-ffile-prefix-map=${CMAKE_BINARY_DIR}=."
)
cmake_language(DEFER CALL _launcher_relocate_interface_libraries)
