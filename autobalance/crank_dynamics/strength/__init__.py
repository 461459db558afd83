"""Stress and safety of fillets and webs."""
