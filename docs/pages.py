"""What pages tell their readers to type: the commands of ```sh blocks, one a line, comments taken off."""
import re


def commands_of(page):
    """Lines of shell of the page's ```sh blocks, in order."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    lines = [re.sub(r"\s+#\s.*$", "", line).strip() for block in blocks for line in block.splitlines()]
    return [line for line in lines if line]
