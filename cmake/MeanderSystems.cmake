# meander_older_systems: for programs and libraries that are to run on systems older than the one they are built on. Of
# their functions of the C library two are newer than all others: hypot, which got another version for errno's sake, and
# arc4random_buf, which an archive calls (libexpat). These calls go to jobs/cli/older_systems.cpp. jobs/python/distribution.py
# says which versions remain.
add_library(meander_older_systems OBJECT ${PROJECT_SOURCE_DIR}/jobs/cli/older_systems.cpp)
target_link_libraries(meander_older_systems PRIVATE meander_flags)
if(NOT MEANDER_SANITIZE)
  target_link_options(meander_older_systems INTERFACE -Wl,--wrap=hypot -Wl,--wrap=arc4random_buf)
endif()
