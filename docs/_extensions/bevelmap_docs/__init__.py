"""What the documentation site adds to Sphinx: formulas as MathML, and pages made from the program itself."""
