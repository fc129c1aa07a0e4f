"""The page in a browser: thin views over case files, studies and results folders."""
