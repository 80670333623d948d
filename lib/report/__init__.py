"""What the report needs beside the library: data files, drawings, tables in words, the campaign and its significance tests.

A package of the checkout, next to the library but not installed with it. It imports the library, and never the other way.
"""
