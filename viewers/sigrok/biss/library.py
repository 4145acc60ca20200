'''
The Python module biss. A decoder of sigrok is a Python module with the decoder's name, so that
`import biss` finds the decoder itself: the library is loaded under another name.
'''

import importlib.util
import os
import sys

NAME = 'biss_library'


class LibraryError(Exception):
    pass


def load():
    if NAME in sys.modules:
        return sys.modules[NAME]
    for folder in sys.path:
        package = os.path.join(folder, 'biss')
        init = os.path.join(package, '__init__.py')
        if os.path.isfile(os.path.join(package, 'pd.py')) or not os.path.isfile(init):
            continue
        spec = importlib.util.spec_from_file_location(NAME, init,
                                                      submodule_search_locations=[package])
        module = importlib.util.module_from_spec(spec)
        sys.modules[NAME] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[NAME]
            raise
        return module
    raise LibraryError('The Python module biss is not installed (package python3-biss).')
