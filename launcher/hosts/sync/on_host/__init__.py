"""What runs on a host while it is synchronized: sent there as source, and never installed.

The modules use nothing but Python's library, and import only each other.
"""

# Each imports only those before it.
MODULES = ("wire", "pip_messages", "store", "releases", "environment", "main")
