"""Finds OpenCL drivers, including drivers without an .icd file: in containers a GPU's driver is often in a separate folder."""
import ctypes
import os
import pathlib

REGISTERED = pathlib.Path("/etc/OpenCL/vendors")
FOLDERS = ("/usr/local/nvidia/lib64", "/usr/local/nvidia/lib", "/usr/local/cuda/lib64", "/usr/local/cuda/compat", "/usr/lib/x86_64-linux-gnu",
           "/usr/lib64", "/usr/lib", "/usr/lib/wsl/lib", "/opt/rocm/lib", "/opt/rocm/opencl/lib", "/opt/amdgpu-pro/lib/x86_64-linux-gnu",
           "/usr/lib/x86_64-linux-gnu/intel-opencl", "/usr/lib64/intel-opencl")
LIBRARIES = ("libnvidia-opencl.so.1", "libamdocl64.so", "libigdrcl.so")


def loads(library):
    try:
        ctypes.CDLL(str(library))
        return True
    except OSError:
        return False


def unregistered():
    """Returns loadable libraries of GPU drivers without an .icd file."""
    vendors = pathlib.Path(os.environ.get("OCL_ICD_VENDORS", REGISTERED))
    named = {pathlib.Path(file.read_text().strip()).name for file in vendors.glob("*.icd")} if vendors.is_dir() else set()
    found = []
    for name in LIBRARIES:
        if name in named:
            continue
        for folder in (*FOLDERS, *filter(None, os.environ.get("LD_LIBRARY_PATH", "").split(":"))):
            library = pathlib.Path(folder) / name
            if library.exists() and loads(library):
                found.append(library)
                break
    return found


def vendors_folder(into):
    """Returns a folder for OCL_ICD_VENDORS with registered and unregistered drivers; None if all are registered."""
    extra = unregistered()
    if not extra:
        return None
    into.mkdir(parents=True, exist_ok=True)
    vendors = pathlib.Path(os.environ.get("OCL_ICD_VENDORS", REGISTERED))
    for file in vendors.glob("*.icd") if vendors.is_dir() else ():
        (into / file.name).write_text(file.read_text())
    for library in extra:
        (into / (library.name.split(".")[0] + ".icd")).write_text(f"{library}\n")
    return into
