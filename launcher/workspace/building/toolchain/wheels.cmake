# Included by every `project()` of a package (CMAKE_PROJECT_INCLUDE).
#
# The CMake files of the ROS wheels name the folders of Python and numpy on the machine that made
# the wheels. After the package has been configured the imported targets are corrected in memory;
# the installed files stay as they are.
#
# A package may call project() before cmake_minimum_required(), or ask for an old version: the
# policies of these files, and of what they find, are always the same.

cmake_policy(PUSH)
cmake_policy(VERSION 3.19)

include("${CMAKE_CURRENT_LIST_DIR}/relocatable.cmake")
list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}/modules")

function(_launcher_correct_imported_targets)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT folders)
      continue()
    endif()
    set(existing "")
    set(is_changed FALSE)
    foreach(folder IN LISTS folders)
      if(folder MATCHES "^/opt/python/" AND NOT IS_DIRECTORY "${folder}")
        set(is_changed TRUE)
      else()
        list(APPEND existing "${folder}")
      endif()
    endforeach()
    if(is_changed)
      list(APPEND existing "${LAUNCHER_PYTHON_INCLUDE}" "${LAUNCHER_NUMPY_INCLUDE}")
      set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${existing}")
    endif()
  endforeach()
endfunction()

# A package of the workspace that hides one of the wheels has no targets for C++, which those of
# other wheels link to.
function(_launcher_leave_out_missing_cpp_targets)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(libraries ${target} INTERFACE_LINK_LIBRARIES)
    if(NOT libraries)
      continue()
    endif()
    set(existing "")
    foreach(library IN LISTS libraries)
      if(TARGET "${library}" OR NOT library MATCHES "^[a-z0-9_]+::[a-z0-9_]+__rosidl_[a-z_]+_cpp$")
        list(APPEND existing "${library}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_LINK_LIBRARIES "${existing}")
  endforeach()
endfunction()

# Deferred once, to the end of the top folder: a package may call project() more than once.
get_property(_launcher_is_deferred GLOBAL PROPERTY LAUNCHER_IS_DEFERRED)
if(NOT _launcher_is_deferred)
  set_property(GLOBAL PROPERTY LAUNCHER_IS_DEFERRED TRUE)
  cmake_language(DEFER DIRECTORY "${CMAKE_SOURCE_DIR}" CALL _launcher_correct_imported_targets)
  if(NOT LAUNCHER_CPP)
    cmake_language(DEFER DIRECTORY "${CMAKE_SOURCE_DIR}"
      CALL _launcher_leave_out_missing_cpp_targets)
  endif()
endif()
unset(_launcher_is_deferred)

# Python uses the C generators only. Those for C++ take half of the time, and rclcpp is no wheel.
if(NOT LAUNCHER_CPP AND NOT COMMAND _launcher_is_cpp_generator)
  macro(_launcher_is_cpp_generator result name)
    string(REGEX MATCH "^rosidl_(generator|typesupport|typesupport_introspection|typesupport_fastrtps)_cpp$"
      ${result} "${name}")
  endmacro()

  # Defines ament_register_extension, which its include guard keeps from being defined again.
  find_package(ament_cmake_core QUIET)

  macro(ament_register_extension extension_point package_name cmake_filename)
    _launcher_is_cpp_generator(_launcher_is_cpp "${package_name}")
    if(NOT _launcher_is_cpp)
      list(APPEND AMENT_EXTENSIONS_${extension_point} "${package_name}:${cmake_filename}")
    endif()
  endmacro()
endif()

# rosidl_adapt_interfaces reads its list of files as ASCII, which breaks folders with an umlaut:
# the list is read again. CMake calls the function that is replaced by its name with an underscore.
if(CMAKE_BINARY_DIR MATCHES "[^ -~]" AND NOT COMMAND _rosidl_adapt_interfaces)
  find_package(rosidl_adapter QUIET)
  if(COMMAND rosidl_adapt_interfaces)
    function(rosidl_adapt_interfaces variable arguments_file)
      _rosidl_adapt_interfaces(_ "${arguments_file}" ${ARGN})
      cmake_parse_arguments(ARG "" "TARGET" "" ${ARGN})
      set(list "${CMAKE_CURRENT_BINARY_DIR}/rosidl_adapter/${ARG_TARGET}.idls")
      file(STRINGS "${list}" tuples ENCODING UTF-8)
      set(${variable} ${tuples} PARENT_SCOPE)
    endfunction()
  endif()
endif()

cmake_policy(POP)
