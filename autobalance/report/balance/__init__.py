"""The main report: values, text, comparison, workbook."""
