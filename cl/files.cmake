# Every file of device code, relative to cl/: these are embedded in the library. One line each.
set(SIMULI_CL_FILES
)
